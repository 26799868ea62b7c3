//! Describes the machine of a run, for its manifest.

use record::Machine;

/// Reads what the kernel says about the machine; what it does not say is `unknown` or 0.
#[must_use]
pub fn machine() -> Machine {
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
        awake: false,
    }
}
