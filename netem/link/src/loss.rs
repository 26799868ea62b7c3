//! Loss as a state in time: whether a packet that enters now is lost.
//!
//! It is decided once per slot for all packets of the slot, so that the seed and the time alone
//! determine a packet's fate.

use crate::draws::Draws;
use crate::law::Law;
use crate::profile::Loss;
use crate::spells::Spells;
use crate::trace::Trace;

/// The loss process of one direction.
#[derive(Debug, Clone)]
pub(crate) struct LossProcess {
    loss: Loss,
    bad: Option<Spells>,
    draws: Draws,
    /// The slot of the newest query, since the next is mostly about it or the one after it.
    slot: Slot,
}

/// A slot: its number, and when it begins.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    number: u64,
    start_ns: u64,
}

impl Slot {
    /// The slot of `slot_ns` that contains `t_ns`; this is another of the same length.
    #[inline]
    fn at(self, t_ns: u64, slot_ns: u64) -> Self {
        let start_ns = self.start_ns;
        // Divisions cost more than all the rest.
        match t_ns.checked_sub(start_ns) {
            Some(within_ns) if within_ns < slot_ns => self,
            Some(within_ns) if within_ns - slot_ns < slot_ns => Self {
                number: self.number + 1,
                start_ns: start_ns + slot_ns,
            },
            _ => Self {
                number: t_ns / slot_ns,
                start_ns: t_ns - t_ns % slot_ns,
            },
        }
    }
}

impl LossProcess {
    pub(crate) fn new(loss: &Loss, draws: Draws, spell_draws: Draws) -> Self {
        let bad = match loss {
            Loss::GilbertElliott {
                good_ns, bad_ns, ..
            } => Some(Spells::new(
                *good_ns as f64,
                Law::exponential(*bad_ns as f64),
                spell_draws,
            )),
            _ => None,
        };
        Self {
            loss: loss.clone(),
            bad,
            draws,
            slot: Slot::default(),
        }
    }

    /// Whether a packet that enters at `t_ns` is lost; `trace` is that of the wire.
    #[inline]
    pub(crate) fn lost(&mut self, t_ns: u64, trace: Option<&Trace>) -> bool {
        let share = match &self.loss {
            Loss::Never => return false,
            Loss::Random { share, hold_ns } => {
                self.slot = self.slot.at(t_ns, *hold_ns);
                *share
            }
            Loss::GilbertElliott {
                in_good,
                in_bad,
                hold_ns,
                ..
            } => {
                // The state at its beginning holds for the whole slot.
                self.slot = self.slot.at(t_ns, *hold_ns);
                let start_ns = self.slot.start_ns;
                let bad = self.bad.as_mut().and_then(|bad| bad.end_at(start_ns));
                if bad.is_some() { *in_bad } else { *in_good }
            }
            Loss::Trace { hold_ns } => {
                self.slot = self.slot.at(t_ns, *hold_ns);
                trace.map_or(0.0, |trace| trace.step_at(t_ns).1.loss)
            }
        };
        // Draws lie in (0, 1): a share of 0 never loses a packet and a share of 1 always does.
        self.draws.at(self.slot.number) < share
    }

    /// Until when it stays as it is at `t_ns`, which was the last instant asked for.
    #[inline]
    pub(crate) fn stays_until_ns(&self, t_ns: u64, trace: Option<&Trace>) -> u64 {
        let slot_ns = match &self.loss {
            Loss::Never => return u64::MAX,
            Loss::Random { hold_ns, .. }
            | Loss::GilbertElliott { hold_ns, .. }
            | Loss::Trace { hold_ns } => *hold_ns,
        };
        let slot_ends_ns = self.slot.start_ns.saturating_add(slot_ns);
        match (&self.loss, trace) {
            (Loss::Trace { .. }, Some(trace)) => slot_ends_ns.min(trace.step_at(t_ns).0.end),
            _ => slot_ends_ns,
        }
    }

    pub(crate) fn forget_before(&mut self, t_ns: u64) {
        if let Some(bad) = &mut self.bad {
            bad.forget_before(t_ns);
        }
    }
}
