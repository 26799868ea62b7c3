//! All faults of one direction together, asked for a packet at an instant.

use crate::fault::{Effect, Fault, Seeded, Span, Twist};
use crate::way::Way;

/// All faults of one direction but those of the delay, which the wire has.
#[derive(Debug, Clone, Default)]
pub(crate) struct Faults(Vec<Seeded>);

impl Faults {
    pub(crate) fn new(faults: &[Fault], way: Way, seed: u64) -> Self {
        let delays = |fault: &&Fault| matches!(fault.effect, Effect::Delay { .. });
        let others = faults.iter().filter(|fault| !delays(fault));
        Self(others.map(|fault| Seeded::new(fault, way, seed)).collect())
    }

    /// Those of the delay.
    pub(crate) fn of_delay(faults: &[Fault], way: Way, seed: u64) -> Vec<Seeded> {
        let delays = |fault: &&Fault| matches!(fault.effect, Effect::Delay { .. });
        let faults = faults.iter().filter(delays);
        faults.map(|fault| Seeded::new(fault, way, seed)).collect()
    }

    /// Whether a packet that enters now is lost.
    pub(crate) fn lost(&mut self, t_ns: u64) -> bool {
        self.0.iter_mut().any(|fault| match fault.effect() {
            Effect::Down => fault.is_on(t_ns),
            Effect::Loss { share } => fault.is_hit(t_ns, share),
            _ => false,
        })
    }

    /// Whether a packet that enters now is damaged, so that its receiver discards it.
    pub(crate) fn corrupts(&mut self, t_ns: u64) -> bool {
        self.0.iter_mut().any(|fault| match fault.effect() {
            Effect::Corrupt { share } => fault.is_hit(t_ns, share),
            _ => false,
        })
    }

    /// How long a packet that enters now is held back at the end of the link, so that later ones
    /// overtake it.
    pub(crate) fn held_back_ns(&mut self, t_ns: u64) -> u64 {
        let held_ns = self.0.iter_mut().map(|fault| match fault.effect() {
            Effect::Reorder { share, by_ns } if fault.is_hit(t_ns, share) => by_ns,
            _ => 0,
        });
        held_ns.fold(0, u64::saturating_add)
    }

    /// What is done to a packet that enters now and is not lost.
    pub(crate) fn twist(&mut self, t_ns: u64) -> Twist {
        let mut twist = Twist::NONE;
        for fault in &mut self.0 {
            match fault.effect() {
                Effect::Duplicate { share } => twist.twice |= fault.is_hit(t_ns, share),
                Effect::Corrupt { share } => {
                    if twist.flip.is_none() && fault.is_hit(t_ns, share) {
                        twist.flip = Some(fault.bit(t_ns));
                    }
                }
                Effect::Reset => twist.reset |= fault.is_on(t_ns),
                Effect::Rebind => twist.rebind |= fault.is_on(t_ns),
                Effect::Down
                | Effect::Delay { .. }
                | Effect::Loss { .. }
                | Effect::Reorder { .. } => {}
            }
        }
        twist
    }

    /// Whether a fault that loses or damages packets is in force, whatever it does in this slot.
    pub(crate) fn is_lossy(&mut self, t_ns: u64) -> bool {
        self.0.iter_mut().any(|fault| match fault.effect() {
            Effect::Down | Effect::Loss { .. } | Effect::Corrupt { .. } => fault.is_on(t_ns),
            _ => false,
        })
    }

    /// The last instant up to `t_ns` at which connections of TCP may have been broken: within a reset,
    /// and where ports change and where they change back.
    pub(crate) fn broken_ns(&mut self, t_ns: u64) -> Option<u64> {
        let broken_ns = self.0.iter_mut().filter_map(|fault| {
            let Span {
                start_ns, is_spell, ..
            } = fault.span_at(t_ns);
            match fault.effect() {
                Effect::Reset if is_spell => Some(t_ns),
                Effect::Reset | Effect::Rebind => (is_spell || start_ns > 0).then_some(start_ns),
                _ => None,
            }
        });
        broken_ns.max()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::{Again, SLOT_NS};

    #[test]
    fn a_share_is_of_the_slots_of_a_spell_and_of_no_others() {
        let fault = Fault {
            number: 0,
            at_ns: 1_000 * SLOT_NS,
            for_ns: 20_000 * SLOT_NS,
            again: Again::Never,
            times: None,
            effect: Effect::Corrupt { share: 0.3 },
        };
        let mut faults = Faults::new(&[fault], Way::Down, 3);
        let count = |faults: &mut Faults, slots: std::ops::Range<u64>| {
            slots
                .filter(|slot| faults.twist(slot * SLOT_NS + 7).flip.is_some())
                .count()
        };
        assert_eq!(count(&mut faults, 0..1_000), 0);
        assert_eq!(count(&mut faults, 21_000..30_000), 0);
        // Standard error: sqrt(0.3 * 0.7 / 20 000) = 0.0032; the limit is four of them.
        let share = count(&mut faults, 1_000..21_000) as f64 / 20_000.0;
        assert!((share - 0.3).abs() < 0.013, "{share}");
        assert!(faults.corrupts(1_000 * SLOT_NS) == faults.twist(1_000 * SLOT_NS).flip.is_some());
    }
}
