//! The pulse: a thread on each processor that wakes every millisecond, ahead of every part of the run
//! where it may, and writes down when it was late. So a machine that stood still says so itself.
//!
//! What that makes of a run is judged elsewhere.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use certificate::Pause;
use endpoint::report::{Policy, Scheduling};
use judge::Pulse;
use pace::{Pacer, now_ns};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// From beat to beat.
const BEAT_NS: u64 = 1_000_000;

/// A beat that is this late is written down.
const GAP_NS: u64 = 2_000_000;

/// Gaps that one processor's thread writes down.
const KEPT: usize = 200;

/// Ahead of the plant's tick (50), the highest of a run: only what is no part of it comes before.
const PRIORITY: u8 = 51;

/// Processors that get a thread: a run has few threads, and a large machine needs no more.
const MOST: usize = 8;

/// The threads while they run.
#[derive(Debug)]
pub(crate) struct Pulses {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<Pulse>>,
    /// What the host had taken from the processors before.
    stolen_ns: u64,
}

impl Pulses {
    /// Starts a thread on each processor of this process; on none where that is refused.
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
            stolen_ns: agent::stolen_ns(),
        }
    }

    /// Ends the threads, and puts together what they saw.
    pub(crate) fn finish(mut self) -> Pulse {
        self.stop.store(true, Ordering::Relaxed);
        let mut all = Pulse {
            real_time: true,
            stolen_ms: agent::stolen_ns().saturating_sub(self.stolen_ns) as f64 * 1e-6,
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
    let granted = pace::ask(Some(PRIORITY));
    // It never spins: it takes nothing from whom it watches.
    let pacer = Pacer::new(&Scheduling::ordinary());
    let mut pulse = Pulse {
        processors: 1,
        real_time: granted.policy == Policy::Fifo,
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
        // Generous: a machine under test is busy, and beats that are late are left out.
        assert!(pulse.processors > 0 && pulse.beats > 10);
        assert!(pulse.beats <= 400 * pulse.processors as u64);
    }
}
