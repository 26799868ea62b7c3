//! Disturbs processes: stops and continues them, or takes their processors away.

use std::thread;

use clock::now::now_ns;
use clock::pacer::Pacer;
use rustix::process::{Pid, Signal, kill_process};
use rustix::thread::{CpuSet, sched_setaffinity};

use crate::target::{Target, family};

const MS: u64 = 1_000_000;

/// Higher than everything in a cell, so that a stop lasts as long as stated.
const PRIORITY: u8 = 60;
/// The highest priority.
const HIGHEST: u8 = 99;

/// Time after the controller's start. Echoes come every 100 ms from that start on, so a disturbance
/// that comes every 100 ms falls between two of them and meets none.
const PHASE_NS: u64 = 40 * MS;
/// In the middle of the step response.
const ONCE_NS: u64 = 140 * MS;

/// The process to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Who {
    Player,
    Plant,
    Controller,
}

/// How long, and how often: once, or every so many ms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beat {
    length_ms: u64,
    every_ms: Option<u64>,
}

impl Beat {
    pub(crate) const fn once(length_ms: u64) -> Self {
        let every_ms = None;
        Self {
            length_ms,
            every_ms,
        }
    }

    pub(crate) const fn each(length_ms: u64, every_ms: u64) -> Self {
        let every_ms = Some(every_ms);
        Self {
            length_ms,
            every_ms,
        }
    }

    /// Calls `down`, after its length `up`, and so on, as long as `target` runs. Returns how often,
    /// and the longest time between the two, to compare with what was requested.
    fn play(
        self,
        target: &Target,
        pacer: &mut Pacer,
        mut down: impl FnMut(u64) -> bool,
        mut up: impl FnMut(),
    ) -> String {
        let first_ns = target.start_ns + self.every_ms.map_or(ONCE_NS, |_| PHASE_NS);
        let length_ns = self.length_ms * MS;
        let (mut count, mut longest_ns) = (0, 0);
        let mut due_ns = first_ns;
        while due_ns + length_ns <= target.end_ns() && !target.has_ended() {
            pacer.sleep_until(due_ns);
            let began_ns = now_ns();
            if !down(due_ns + length_ns) {
                break;
            }
            pacer.sleep_until(due_ns + length_ns);
            up();
            count += 1;
            longest_ns = (now_ns() - began_ns).max(longest_ns);
            let Some(every_ms) = self.every_ms else {
                break;
            };
            due_ns += every_ms * MS;
        }
        format!(
            "{count} times, for {:.1} ms at most",
            longest_ns as f64 / 1e6
        )
    }
}

/// Stops a process of the cell, with all that it has started.
pub(crate) fn stop(target: &Target, who: Who, beat: Beat) -> Result<String, String> {
    let process = match who {
        Who::Player => target.player.ok_or("over loopback there is no player")?,
        Who::Plant => target.plant,
        Who::Controller => target.controller,
    };
    target.await_beginning()?;
    let family: Vec<_> = family(process)
        .into_iter()
        .filter_map(|number| Pid::from_raw(number.cast_signed()))
        .collect();
    let signal = |signal| {
        let sent = family.iter().map(|member| kill_process(*member, signal));
        sent.filter(Result::is_ok).count() > 0
    };
    let mut pacer = Pacer::new(&clock::scheduling::ask(Some(PRIORITY)));
    let done = beat.play(
        target,
        &mut pacer,
        |_| signal(Signal::STOP),
        || {
            signal(Signal::CONT);
        },
    );
    Ok(format!("stopped {done}"))
}

/// Takes every processor away from everything that does not have the highest priority.
pub(crate) fn hog(target: &Target, beat: Beat) -> Result<String, String> {
    target.await_beginning()?;
    let processors = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let hogs: Vec<_> = (0..processors)
            .map(|processor| {
                scope.spawn(move || {
                    let mut only = CpuSet::new();
                    only.set(processor);
                    sched_setaffinity(None, &only)
                        .map_err(|problem| format!("processor {processor}: {problem}"))?;
                    let scheduling = clock::scheduling::ask(Some(HIGHEST));
                    if let Some(refused) = &scheduling.refused {
                        return Err(format!("no SCHED_FIFO {HIGHEST}: {refused}"));
                    }
                    let busy = |until_ns| {
                        while now_ns() < until_ns {
                            std::hint::spin_loop();
                        }
                        true
                    };
                    Ok(beat.play(target, &mut Pacer::new(&scheduling), busy, || {}))
                })
            })
            .collect();
        let done = hogs.into_iter().map(|hog| {
            hog.join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        let done: Vec<_> = done.collect::<Result<_, _>>()?;
        Ok(format!("each processor taken {}", done.join("; ")))
    })
}
