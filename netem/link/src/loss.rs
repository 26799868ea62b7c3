//! Loss as a state in time: whether a packet that enters now is lost.
//!
//! Decided once per slot, for every packet of the slot alike, so that the fate
//! of a packet is known from the seed and the time alone.

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
        }
    }

    /// Whether a packet that enters at `t_ns` is lost; `trace` is the wire's.
    pub(crate) fn lost(&mut self, t_ns: u64, trace: Option<&Trace>) -> bool {
        let (share, slot_ns) = match &self.loss {
            Loss::Never => return false,
            Loss::Random { share, hold_ns } => (*share, *hold_ns),
            Loss::GilbertElliott {
                in_good,
                in_bad,
                hold_ns,
                ..
            } => {
                // The whole slot takes the state that holds at its beginning.
                let slot_start_ns = t_ns - t_ns % hold_ns;
                let bad = self.bad.as_mut().and_then(|bad| bad.end_at(slot_start_ns));
                (if bad.is_some() { *in_bad } else { *in_good }, *hold_ns)
            }
            Loss::Trace { hold_ns } => {
                let share = trace.map_or(0.0, |trace| trace.step_at(t_ns).1.loss);
                (share, *hold_ns)
            }
        };
        // Draws lie in (0, 1): a share of 0 never loses and one of 1 always.
        self.draws.at(t_ns / slot_ns) < share
    }

    pub(crate) fn forget_before(&mut self, t_ns: u64) {
        if let Some(bad) = &mut self.bad {
            bad.forget_before(t_ns);
        }
    }
}
