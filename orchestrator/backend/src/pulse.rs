//! The pulse: a thread on each processor that wakes every millisecond, with priority over every part of
//! the run if that is allowed, and records when it woke late. So the run itself shows when its machine
//! stood still.
//!
//! `judge` decides what that means for a run.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use clock::now::now_ns;
use clock::pacer::Pacer;
use clock::scheduling::Granted;
use link::certificate::Pause;
use plan::evidence::Pulse;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Time from one beat to the next.
const BEAT_NS: u64 = 1_000_000;

/// A beat that is at least this late is recorded.
const GAP_NS: u64 = 2_000_000;

/// Most gaps that one processor's thread records.
const KEPT: usize = 200;

/// Above the plant's tick (50), which has the highest priority in a run: only what is not part of the
/// run comes before a beat.
const PRIORITY: u8 = 51;

/// Most processors that get a thread: a run has few threads, so a large machine needs no more.
const MOST: usize = 8;

/// The running threads.
#[derive(Debug)]
pub(crate) struct Pulses {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<Pulse>>,
    /// Time that the host had taken from the processors before, ns.
    stolen_ns: u64,
}

impl Pulses {
    /// Starts a thread on each processor that this process may use, except where starting one is
    /// refused.
    pub(crate) fn start() -> Pulses {
        let stop = Arc::new(AtomicBool::new(false));
        let own = sched_getaffinity(None).unwrap_or_default();
        let processors = (0..CpuSet::MAX_CPU)
            .filter(|cpu| own.is_set(*cpu))
            .take(MOST);
        let threads = processors
            .filter_map(|cpu| {
                let stop = Arc::clone(&stop);
                let builder = std::thread::Builder::new().name(format!("pulse {cpu}"));
                builder.spawn(move || beat(cpu, &stop)).ok()
            })
            .collect();
        Pulses {
            stop,
            threads,
            stolen_ns: process::stolen_ns(),
        }
    }

    /// Ends the threads, and combines what they saw.
    pub(crate) fn finish(mut self) -> Pulse {
        self.stop.store(true, Ordering::Relaxed);
        let mut all = Pulse {
            real_time: true,
            stolen_ms: process::stolen_ns().saturating_sub(self.stolen_ns) as f64 * 1e-6,
            ..Pulse::default()
        };
        for thread in self.threads.drain(..) {
            let Ok(one) = thread.join() else { continue };
            all.processors += 1;
            all.real_time &= one.real_time;
            all.beats += one.beats;
            all.longest_ms = all.longest_ms.max(one.longest_ms);
            all.gaps.extend(one.gaps);
        }
        all.gaps.sort_by_key(|gap| gap.t_ns);
        all
    }
}

impl Drop for Pulses {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Beats on one processor until `stop` is set.
fn beat(cpu: usize, stop: &AtomicBool) -> Pulse {
    let mut set = CpuSet::new();
    set.set(cpu);
    if let Err(error) = sched_setaffinity(None, &set) {
        tracing::debug!(%error, cpu, "the pulse is not bound to its processor");
    }
    let granted = clock::scheduling::ask(Some(PRIORITY));
    // It never spins, so it takes no time from the parts it watches.
    let mut pacer = Pacer::new(&Granted::ordinary());
    let mut pulse = Pulse {
        processors: 1,
        real_time: granted.fifo_priority.is_some(),
        gaps: Vec::with_capacity(KEPT),
        ..Pulse::default()
    };
    let mut due_ns = now_ns() + BEAT_NS;
    while !stop.load(Ordering::Relaxed) {
        pacer.sleep_until(due_ns);
        let now = now_ns();
        let late_ns = now - due_ns;
        pulse.beats += 1;
        pulse.longest_ms = pulse.longest_ms.max(late_ns as f64 * 1e-6);
        if late_ns >= GAP_NS && pulse.gaps.len() < KEPT {
            pulse.gaps.push(Pause {
                t_ns: now,
                ns: late_ns,
            });
        }
        due_ns = (due_ns + BEAT_NS).max(now);
    }
    pulse
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn each_processor_beats_about_a_thousand_times_a_second() {
        let pulses = Pulses::start();
        std::thread::sleep(Duration::from_millis(300));
        let pulse = pulses.finish();
        // Generous, since a machine under test is busy and skips beats when it is late.
        assert!(pulse.processors > 0 && pulse.beats > 10);
        assert!(pulse.beats <= 400 * pulse.processors as u64);
    }
}
