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

    /// Whether a packet that enters at `t_ns` is lost; `trace` is that of the wire.
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
                // The state at its beginning holds for the whole slot.
                let slot_start_ns = t_ns - t_ns % hold_ns;
                let bad = self.bad.as_mut().and_then(|bad| bad.end_at(slot_start_ns));
                (if bad.is_some() { *in_bad } else { *in_good }, *hold_ns)
            }
            Loss::Trace { hold_ns } => {
                let share = trace.map_or(0.0, |trace| trace.step_at(t_ns).1.loss);
                (share, *hold_ns)
            }
        };
        // Draws lie in (0, 1): a share of 0 never loses a packet and a share of 1 always does.
        self.draws.at(t_ns / slot_ns) < share
    }

    pub(crate) fn forget_before(&mut self, t_ns: u64) {
        if let Some(bad) = &mut self.bad {
            bad.forget_before(t_ns);
        }
    }
}
