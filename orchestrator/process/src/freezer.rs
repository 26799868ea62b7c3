//! Lets a process and its descendants stand still at instants known beforehand, from a thread in the process that
//! started it.
//!
//! It stops them by SIGSTOP, which no program can catch, and lets them go on by SIGCONT. Whatever happens to the
//! thread's owner, they go on when the thread ends. Why they are to stand still is not known here.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use rustix::process::{Pid, Signal, kill_process};

use crate::look;

/// A process that is stopped may just have started another: its descendants are looked for again until none is
/// new, but no more often than this.
const MOST_LOOKS: usize = 8;

/// Beginning and end of a stop, ns on the monotonic clock.
pub type Stop = [u64; 2];

/// A thread that stops a process. Dropping it lets the process go on.
#[derive(Debug)]
pub(crate) struct Freezer {
    done: Arc<Mutex<Vec<Stop>>>,
    /// Dropping it ends the thread.
    end: Option<Sender<()>>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Freezer {
    /// Will stop the process `pid` at these times, which are in order. If no thread can be started, it is not
    /// stopped, and [`Freezer::done`] shows it.
    pub(crate) fn start(pid: u32, stops: Vec<Stop>) -> Freezer {
        let (end, ended) = channel();
        let done = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&done);
        let stopping = move || {
            let mut took_ns = 0;
            for stop in stops {
                if !freeze(pid, stop, &mut took_ns, &ended, &kept) {
                    break;
                }
            }
        };
        let thread = thread::Builder::new().name("freezer".to_owned());
        Freezer {
            done,
            end: Some(end),
            thread: thread.spawn(stopping).ok(),
        }
    }

    /// The stops that are over, as they were: each from the signal to stop until that to go on.
    pub(crate) fn done(&self) -> Vec<Stop> {
        let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        done.clone()
    }

    /// Lets the process go on, and does not stop it again.
    pub(crate) fn release(&mut self) {
        self.end.take();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Freezer {
    fn drop(&mut self) {
        self.release();
    }
}

/// Stops a process once. Returns whether to go on with the next stop. To let a browser's dozen processes go on takes
/// most of a millisecond: it is begun earlier by what the last time took, so that the last of them goes on in time.
fn freeze(
    pid: u32,
    [from_ns, to_ns]: Stop,
    took_ns: &mut u64,
    ended: &Receiver<()>,
    done: &Mutex<Vec<Stop>>,
) -> bool {
    if !waits(ended, from_ns) || !look::is_there(pid) {
        return false;
    }
    let begun_ns = now_ns();
    let mut stopped: Vec<u32> = Vec::new();
    for _ in 0..MOST_LOOKS {
        let family = look::family(pid);
        let new: Vec<u32> = family
            .into_iter()
            .filter(|pid| !stopped.contains(pid))
            .collect();
        if new.is_empty() {
            break;
        }
        new.iter().for_each(|pid| signal(*pid, Signal::STOP));
        stopped.extend(new);
    }
    let lead_ns = (*took_ns).min(to_ns.saturating_sub(from_ns) / 2);
    let goes_on = waits(ended, to_ns.saturating_sub(lead_ns));
    // Children first, so that no parent misses that they stood still.
    stopped
        .iter()
        .rev()
        .for_each(|pid| signal(*pid, Signal::CONT));
    let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
    let over_ns = now_ns();
    *took_ns = (over_ns + lead_ns).saturating_sub(to_ns);
    done.push([begun_ns, over_ns]);
    goes_on
}

/// Waits until an instant. Returns whether it has come, rather than the freezer's end.
fn waits(ended: &Receiver<()>, until_ns: u64) -> bool {
    let left = Duration::from_nanos(until_ns.saturating_sub(now_ns()));
    ended.recv_timeout(left) == Err(RecvTimeoutError::Timeout)
}

fn signal(pid: u32, signal: Signal) {
    if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
        let _ = kill_process(pid, signal);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::process::Command;
    use std::time::Instant;

    fn until(is_so: impl Fn() -> bool) -> bool {
        let deadline = Instant::now() + Duration::from_secs(10);
        while !is_so() && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(2));
        }
        is_so()
    }

    #[test]
    fn a_process_and_its_child_stand_still_when_asked_and_go_on_when_the_freezer_ends() {
        let mut child = Command::new("sh")
            .args(["-c", "sleep 20; true"])
            .spawn()
            .unwrap();
        let pid = child.id();
        assert!(until(|| look::family(pid).len() == 2));
        let are_stopped = || look::family(pid).into_iter().all(look::is_stopped);
        const MS: u64 = 1_000_000;
        let now_ns = now_ns();
        let later = [now_ns + 60_000 * MS, now_ns + 60_001 * MS];
        let stops = vec![[now_ns + 20 * MS, now_ns + 220 * MS], later];
        let freezer = Freezer::start(pid, stops);
        assert!(until(are_stopped));
        assert!(until(|| !freezer.done().is_empty()));
        assert!(until(|| !are_stopped()));
        let [begun_ns, over_ns] = freezer.done()[0];
        assert!(begun_ns >= now_ns + 20 * MS && over_ns >= now_ns + 220 * MS);
        drop(freezer);
        let freezer = Freezer::start(pid, vec![[0, u64::MAX]]);
        assert!(until(are_stopped));
        drop(freezer);
        assert!(until(|| !are_stopped()));
        // The shell's child has not been told to die with it.
        for pid in look::family(pid).into_iter().skip(1) {
            signal(pid, Signal::KILL);
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
