//! The first process of the PID namespace of somebody's own program: starts the program, takes in what it
//! leaves behind, and ends as it ends. The kernel then kills everything else in the namespace.
//!
//! A program as first process itself would not get SIGTERM unless it asked for it.

use std::io::{self, Write, stderr};
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use rustix::process::{Pid, Signal, WaitOptions, kill_process, wait};
use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// The exit code where the program cannot be started, as a shell has it.
const NOT_STARTED: u8 = 126;

/// How often to look for a signal before the program is started.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Runs a command to its end, from `not_before_ns` on the monotonic clock on, and passes on SIGTERM and SIGINT.
/// Returns its exit code as a shell reports it.
///
/// # Errors
/// When signals cannot be waited for.
pub fn run(command: &[String], not_before_ns: u64) -> io::Result<u8> {
    let mut signals = Signals::new([SIGCHLD, SIGTERM, SIGINT])?;
    let [program, arguments @ ..] = command else {
        return Ok(NOT_STARTED);
    };
    while let Some(left_ns) = not_before_ns.checked_sub(now_ns()).filter(|ns| *ns > 0) {
        if signals.pending().next().is_some() {
            return Ok(NOT_STARTED);
        }
        thread::sleep(Duration::from_nanos(left_ns).min(LOOK_EVERY));
    }
    // A group of its own, so that Ctrl-C in a terminal reaches it once, from here.
    let child = match Command::new(program)
        .args(arguments)
        .process_group(0)
        .spawn()
    {
        Ok(child) => child,
        Err(problem) => {
            let _ = writeln!(stderr(), "`{program}` cannot be started: {problem}");
            return Ok(NOT_STARTED);
        }
    };
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    loop {
        // Signals may have come together, so all that ended is taken in each time.
        while let Ok(Some((ended, status))) = wait(WaitOptions::NOHANG) {
            if Some(ended) == pid {
                let signal = status.terminating_signal().map(|signal| 128 + signal);
                let code = status.exit_status().or(signal).unwrap_or_default();
                return Ok(u8::try_from(code).unwrap_or(u8::MAX));
            }
        }
        let told = signals.wait().any(|signal| signal != SIGCHLD);
        if told && let Some(pid) = pid {
            let _ = kill_process(pid, Signal::TERM);
        }
    }
}
