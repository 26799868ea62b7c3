//! What a process looks like from outside: whether it was stopped, and how long its threads ran and
//! waited for a processor. Read from `/proc`; what cannot be read is left out.

use std::fs;

use serde::{Deserialize, Serialize};

/// The kernel counts processor time in hundredths of a second for programs, ns, whatever its own tick.
const TICK_NS: u64 = 10_000_000;

/// The search for descendants ends at this number of processes: a browser has some ten.
const MOST: usize = 64;

/// How long the threads of a process and its descendants have run, and have waited, ready, for a
/// processor, since they began: those that have ended among them, whose waits nobody knows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Strain {
    /// Total running time, ns.
    pub ran_ns: u64,
    /// Total time waiting for a processor, ns.
    pub waited_ns: u64,
}

/// Whether a process is stopped, by a signal or by a debugger.
pub(crate) fn is_stopped(pid: u32) -> bool {
    matches!(state(pid), Some('T' | 't'))
}

/// Whether a process exists and is not just a zombie.
pub(crate) fn is_there(pid: u32) -> bool {
    state(pid).is_some_and(|state| !matches!(state, 'Z' | 'X'))
}

/// The kernel's letter for the state of a process.
fn state(pid: u32) -> Option<char> {
    stat(pid)?.chars().next()
}

/// What the kernel's `stat` says of a process after its name, which is in brackets and may hold anything.
fn stat(pid: u32) -> Option<String> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (_, rest) = text.rsplit_once(") ")?;
    Some(rest.to_owned())
}

/// How long the children of a process that have ended ran, and theirs, ns: `cutime` and `cstime`, the fields 16 and
/// 17 of proc(5). A program that starts another one for each message works mostly in these.
fn ended_ns(pid: u32) -> u64 {
    let text = stat(pid).unwrap_or_default();
    // The state is field 3.
    let fields = text.split_whitespace().skip(16 - 3).take(2);
    let ticks: u64 = fields.filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks * TICK_NS
}

/// A process and its descendants; itself first.
pub(crate) fn family(pid: u32) -> Vec<u32> {
    let mut found = vec![pid];
    let mut next = 0;
    while let Some(pid) = found.get(next).copied()
        && found.len() < MOST
    {
        next += 1;
        for thread in threads(pid) {
            let path = format!("/proc/{pid}/task/{thread}/children");
            let text = fs::read_to_string(path).unwrap_or_default();
            found.extend(
                text.split_whitespace()
                    .filter_map(|pid| pid.parse::<u32>().ok()),
            );
        }
    }
    found
}

/// Total strain of these processes.
pub(crate) fn strain(pids: &[u32]) -> Strain {
    let mut strain = Strain::default();
    for &pid in pids {
        strain.ran_ns += ended_ns(pid);
        for thread in threads(pid) {
            let path = format!("/proc/{pid}/task/{thread}/schedstat");
            let text = fs::read_to_string(path).unwrap_or_default();
            let mut numbers = text.split_whitespace().map(|n| n.parse().unwrap_or(0));
            strain.ran_ns += numbers.next().unwrap_or(0);
            strain.waited_ns += numbers.next().unwrap_or(0);
        }
    }
    strain
}

/// Total time that the processors of this machine have been busy, ns; 0 if unknown. Time that the
/// host took from them is not included.
#[must_use]
pub fn busy_ns() -> u64 {
    let [user, nice, system, _idle, _disk, interrupts, soft, _stolen] = spent_ns();
    user + nice + system + interrupts + soft
}

/// Total time that the host has taken from the processors of this machine, ns; 0 if unknown.
#[must_use]
pub fn stolen_ns() -> u64 {
    let [.., stolen] = spent_ns();
    stolen
}

/// How all processors together have spent their time since the machine started, ns, in the kernel's
/// own order.
fn spent_ns() -> [u64; 8] {
    let text = fs::read_to_string("/proc/stat").unwrap_or_default();
    let line = text.lines().next().unwrap_or_default();
    let mut counts = line.split_whitespace().skip(1);
    std::array::from_fn(|_| {
        let ticks: Option<u64> = counts.next().and_then(|field| field.parse().ok());
        ticks.unwrap_or_default() * TICK_NS
    })
}

/// Strain of this process and its descendants.
#[must_use]
pub fn own_strain() -> Strain {
    strain(&family(std::process::id()))
}

fn threads(pid: u32) -> Vec<u32> {
    let entries = fs::read_dir(format!("/proc/{pid}/task"));
    let names = entries.into_iter().flatten().flatten();
    names
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use rustix::process::{Pid, Signal, kill_process};
    use std::process::Command;
    use std::time::{Duration, Instant};

    #[test]
    fn a_process_that_is_stopped_is_seen_so_and_goes_on_afterwards() {
        let mut child = Command::new("sleep").arg("20").spawn().unwrap();
        let pid = Pid::from_raw(child.id().cast_signed()).unwrap();
        assert!(!is_stopped(child.id()));
        kill_process(pid, Signal::STOP).unwrap();
        let deadline = Instant::now() + Duration::from_secs(5);
        while !is_stopped(child.id()) && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(is_stopped(child.id()));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!is_stopped(child.id()));
    }

    #[test]
    fn what_ended_children_ran_for_counts() {
        let before_ns = strain(&[std::process::id()]).ran_ns;
        let busy = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        Command::new("sh").args(["-c", busy]).status().unwrap();
        let ran_ns = ended_ns(std::process::id());
        assert!(ran_ns >= 3 * TICK_NS, "{ran_ns}");
        assert!(strain(&[std::process::id()]).ran_ns >= before_ns + 3 * TICK_NS);
    }

    #[test]
    fn this_process_has_run_and_knows_its_children() {
        let mut child = Command::new("sleep").arg("20").spawn().unwrap();
        let own = std::process::id();
        assert!(family(own).contains(&child.id()));
        // Some kernels have no such file.
        if fs::exists("/proc/self/schedstat").unwrap() {
            assert!(strain(&family(own)).ran_ns > 0);
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
