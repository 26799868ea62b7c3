//! How busy the machine was, by records that no link can touch: what of a message's lateness it explains.

use endpoint::{MessageRow, TickRow};

use crate::limit::{BUSY_HALF, BUSY_TWICE, OTHERS_SHARE};
use crate::quantile::beyond;
use plan::evidence::Watched;

/// What the ends say of their machine.
#[derive(Debug, Clone, Default)]
pub struct Busy {
    /// Processor time of the controller while messages were due, ms; 0 if nobody looked.
    pub(crate) ran_ms: f64,
    /// How long its threads were ready and waited for a processor meanwhile, ms.
    waited_ms: f64,
    /// Share of all processors that other programs had meanwhile.
    others: f64,
    /// How late each tick was, ms.
    ticks_ms: Vec<f64>,
    /// How late each message was sent of a client that keeps its time, ms.
    sends_ms: Vec<f64>,
}

impl Busy {
    /// By what was `watched` of the controller, and by the `ticks` and the `messages` that were to be punctual; none
    /// of those that were asked to be late.
    #[must_use]
    pub fn of(watched: Option<&Watched>, ticks: &[TickRow], messages: &[MessageRow]) -> Busy {
        let late_ms = |due_ns: u64, t_ns: u64| t_ns.saturating_sub(due_ns) as f64 * 1e-6;
        let sends = messages
            .iter()
            .filter_map(|row| Some(late_ms(row.t_due_ns, row.t_send_ns?)));
        let ticks = ticks.iter().map(|row| late_ms(row.t_due_ns, row.t_tick_ns));
        Busy {
            ran_ms: watched.map_or(0.0, |watched| watched.ran_ms),
            waited_ms: watched.map_or(0.0, |watched| watched.waited_ms),
            others: watched.map_or(0.0, |watched| watched.others),
            ticks_ms: ticks.collect(),
            sends_ms: sends.collect(),
        }
    }

    /// How many of `count` messages it may have made late by more than `late_ms`.
    ///
    /// Threads that waited for so long in all made no more late by that much each than fit into it. What made ticks
    /// or deadlines late made messages late as often.
    pub(crate) fn explains(&self, count: usize, late_ms: f64) -> f64 {
        let share = |all: &[f64]| beyond(all, BUSY_HALF * late_ms) as f64 / all.len().max(1) as f64;
        let late = share(&self.ticks_ms).max(share(&self.sends_ms));
        self.waited_ms / late_ms + BUSY_TWICE * late * count as f64
    }

    /// How long each of `count` messages waited for a processor, ms, if they waited alike.
    pub(crate) fn waited_each_ms(&self, count: usize) -> f64 {
        self.waited_ms / count.max(1) as f64
    }

    /// Whether others had so much of the processors that a program may take any time for what it does.
    pub(crate) fn is_crowded(&self) -> bool {
        self.others > OTHERS_SHARE
    }

    /// The controller's processor time a message, ms; `None` if nobody looked.
    pub(crate) fn work_each_ms(&self, count: usize) -> Option<f64> {
        (self.ran_ms > 0.0).then(|| self.ran_ms / count.max(1) as f64)
    }
}
