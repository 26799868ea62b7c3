//! Looks at a process and its descendants every 10 ms, from a thread in the process that started it.
//!
//! Its observations have times, so that a caller who knows when a run was measured can ask for that
//! part. What they say about the run is judged elsewhere.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use serde::{Deserialize, Serialize};

use crate::freezer::Stop;
use crate::look::{self, Strain};

/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Looks from one check of the descendants, and of how long all their threads waited, to the next:
/// for a browser such a check reads some hundred files.
const LOOKS_PER_FAMILY: u64 = 25;

/// Maximum number of stops that are kept, the first ones.
const MOST_STOPS: usize = 10_000;

/// What was seen of a process. Times are ns on the monotonic clock.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// When it was first looked at; 0 if never.
    pub first_ns: u64,
    /// When it was last looked at.
    pub last_ns: u64,
    /// Number of looks so far.
    pub looks: u64,
    /// When it or a descendant was found stopped, by a signal or by a debugger.
    pub stops_ns: Vec<u64>,
    /// Strain so far of it and its descendants, each quarter of a second.
    pub strains: Vec<(u64, Strain)>,
    /// The stops that it was asked for, as they were.
    #[serde(default)]
    pub frozen_ns: Vec<Stop>,
}

impl Seen {
    /// The same, with what was seen `later` of another process in the place of this one. How long that one waited
    /// for processors is kept, and nothing of the earlier one.
    #[must_use]
    pub fn then(mut self, later: Seen) -> Seen {
        if self.looks == 0 {
            return Seen {
                frozen_ns: [self.frozen_ns, later.frozen_ns].concat(),
                ..later
            };
        }
        self.last_ns = self.last_ns.max(later.last_ns);
        self.looks += later.looks;
        self.stops_ns.extend(later.stops_ns);
        self.frozen_ns.extend(later.frozen_ns);
        self.strains = later.strains;
        self
    }

    /// Number of looks from `from_ns` to `to_ns`, assuming that looks are spread evenly.
    #[must_use]
    pub fn looks_within(&self, from_ns: u64, to_ns: u64) -> u64 {
        let all_ns = self.last_ns.saturating_sub(self.first_ns).max(1);
        let within_ns = to_ns
            .min(self.last_ns)
            .saturating_sub(from_ns.max(self.first_ns));
        (self.looks as f64 * within_ns as f64 / all_ns as f64) as u64
    }

    /// When it was found stopped from `from_ns` to `to_ns`.
    pub fn stops_within(&self, from_ns: u64, to_ns: u64) -> impl Iterator<Item = u64> {
        let stops = self.stops_ns.iter().copied();
        stops.filter(move |t_ns| (from_ns..to_ns).contains(t_ns))
    }

    /// Strain from `from_ns` to `to_ns`, between the first and the last look at it; `None` if there
    /// was no such look.
    #[must_use]
    pub fn strain_within(&self, from_ns: u64, to_ns: u64) -> Option<Strain> {
        let inside = |(t_ns, _): &&(u64, Strain)| (from_ns..to_ns).contains(t_ns);
        let (_, first) = self.strains.iter().find(inside)?;
        let (_, last) = self.strains.iter().rev().find(inside)?;
        Some(Strain {
            ran_ns: last.ran_ns.saturating_sub(first.ran_ns),
            waited_ns: last.waited_ns.saturating_sub(first.waited_ns),
        })
    }
}

/// A thread that looks at a process. It ends when this value is dropped or the process is gone.
#[derive(Debug)]
pub(crate) struct Lookout {
    seen: Arc<Mutex<Seen>>,
    /// Dropping it ends the thread.
    _end: Sender<()>,
}

impl Lookout {
    /// Looks at the process `pid` from now on. If no thread can be started, nothing is seen.
    pub(crate) fn start(pid: u32) -> Lookout {
        let (end, ended) = channel();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let kept = Arc::clone(&seen);
        let looking = move || {
            while ended.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
                if !look::is_there(pid) {
                    break;
                }
                let mut seen = kept.lock().unwrap_or_else(PoisonError::into_inner);
                look_once(pid, &mut seen);
            }
        };
        let _ = thread::Builder::new()
            .name("lookout".to_owned())
            .spawn(looking);
        Lookout { seen, _end: end }
    }

    /// What was seen so far.
    pub(crate) fn seen(&self) -> Seen {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.clone()
    }
}

fn look_once(pid: u32, seen: &mut Seen) {
    let now = now_ns();
    if seen.looks == 0 {
        seen.first_ns = now;
    }
    seen.last_ns = now;
    let mut looked_at = vec![pid];
    if seen.looks.is_multiple_of(LOOKS_PER_FAMILY) {
        looked_at = look::family(pid);
        seen.strains.push((now, look::strain(&looked_at)));
    }
    seen.looks += 1;
    if looked_at.into_iter().any(look::is_stopped) && seen.stops_ns.len() < MOST_STOPS {
        seen.stops_ns.push(now);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use rustix::process::{Pid, Signal, kill_process};
    use std::process::Command;
    use std::time::Instant;

    #[test]
    fn a_process_that_is_stopped_is_found_so_by_time() {
        let mut child = Command::new("sleep").arg("20").spawn().unwrap();
        let pid = Pid::from_raw(child.id().cast_signed()).unwrap();
        let lookout = Lookout::start(child.id());
        let until = |is_enough: &dyn Fn(&Seen) -> bool| {
            let deadline = Instant::now() + Duration::from_secs(10);
            while !is_enough(&lookout.seen()) && Instant::now() < deadline {
                thread::sleep(Duration::from_millis(5));
            }
        };
        until(&|seen| seen.looks >= 3);
        assert_eq!(lookout.seen().stops_ns, [0; 0]);
        kill_process(pid, Signal::STOP).unwrap();
        let from_ns = now_ns();
        until(&|seen| seen.stops_ns.len() >= 3);
        kill_process(pid, Signal::CONT).unwrap();
        let seen = lookout.seen();
        let to_ns = now_ns();
        assert!(seen.stops_within(from_ns, to_ns).count() >= 3, "{seen:?}");
        assert_eq!(seen.stops_within(0, from_ns).count(), 0);
        let looks = seen.looks_within(from_ns, to_ns);
        assert!((2..=seen.looks).contains(&looks), "{looks}: {seen:?}");
        assert_eq!(seen.looks_within(to_ns, to_ns + 1_000_000), 0);
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
