//! What machine a run was made on, for its manifest.

use serde::{Deserialize, Serialize};

/// The machine, in the words of its own kernel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Kernel name and release, such as `Linux 6.1.0`.
    pub kernel: String,
    /// Instruction set, such as `x86_64`.
    pub architecture: String,
    /// Processor model, as the kernel names it.
    pub processor: String,
    /// Processors that this process may use.
    pub cores: usize,
    /// Memory in MiB.
    pub memory_mib: u64,
    /// Where the kernel takes its time from, such as `tsc`.
    pub clock_source: String,
}

impl Machine {
    /// Reads what the kernel says; what it does not say is `unknown` or 0.
    #[must_use]
    pub fn here() -> Machine {
        let uname = rustix::system::uname();
        let unknown = || "unknown".to_owned();
        let field = |file: &str, key: &str| {
            let text = std::fs::read_to_string(file).ok()?;
            let line = text.lines().find(|line| line.starts_with(key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        Machine {
            kernel: format!(
                "{} {}",
                uname.sysname().to_string_lossy(),
                uname.release().to_string_lossy()
            ),
            architecture: std::env::consts::ARCH.to_owned(),
            processor: field("/proc/cpuinfo", "model name").unwrap_or_else(unknown),
            cores: std::thread::available_parallelism().map_or(0, usize::from),
            memory_mib: field("/proc/meminfo", "MemTotal")
                .and_then(|text| text.split(' ').next()?.parse::<u64>().ok())
                .map_or(0, |kib| kib / 1024),
            clock_source: std::fs::read_to_string(
                "/sys/devices/system/clocksource/clocksource0/current_clocksource",
            )
            .map_or_else(|_| unknown(), |text| text.trim().to_owned()),
        }
    }
}
