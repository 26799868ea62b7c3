//! When a fault is in force: the stateless law of its spells and slots.

use crate::draws::Draws;
use crate::fault::{Again, Effect, Fault, SLOT_NS};
use crate::way::Way;

/// A spell of a fault, or the gap between two of them: from `start_ns` up to but not including `end_ns`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) start_ns: u64,
    pub(crate) end_ns: u64,
    pub(crate) is_spell: bool,
}

/// A fault under a seed, in one direction.
#[derive(Debug, Clone)]
pub(crate) struct Seeded {
    fault: Fault,
    /// Of the spells.
    times: Draws,
    /// Of the slots.
    slots: Draws,
}

impl Seeded {
    pub(crate) fn new(fault: &Fault, way: Way, seed: u64) -> Self {
        let name = |what: &[u8; 4]| {
            let mut name = [0; 8];
            name[..4].copy_from_slice(what);
            name[4..].copy_from_slice(&fault.number.to_le_bytes());
            name
        };
        let slots = match way {
            Way::Up => b"up.f",
            Way::Down => b"dn.f",
        };
        Self {
            fault: fault.clone(),
            times: Draws::new(seed, &name(b"flt.")),
            slots: Draws::new(seed, &name(slots)),
        }
    }

    pub(crate) fn effect(&self) -> Effect {
        self.fault.effect
    }

    /// The spell at an instant, or the gap around it.
    pub(crate) fn span_at(&mut self, t_ns: u64) -> Span {
        let Fault { at_ns, for_ns, .. } = self.fault;
        let Some(since_ns) = t_ns.checked_sub(at_ns) else {
            return Span {
                start_ns: 0,
                end_ns: at_ns,
                is_spell: false,
            };
        };
        let last = self.fault.last();
        let k = self
            .fault
            .step_ns()
            .map_or(0, |step_ns| since_ns / step_ns)
            .min(last);
        let start_ns = self.start_ns(k);
        let end_ns = start_ns.saturating_add(for_ns);
        let (start_ns, end_ns, is_spell) = if t_ns < start_ns {
            // Spell 0 begins at the beginning of its span, so there is one before.
            let before_ns = self.start_ns(k.saturating_sub(1)).saturating_add(for_ns);
            (before_ns, start_ns, false)
        } else if t_ns < end_ns {
            (start_ns, end_ns, true)
        } else if k == last {
            (end_ns, u64::MAX, false)
        } else {
            (end_ns, self.start_ns(k + 1), false)
        };
        Span {
            start_ns,
            end_ns,
            is_spell,
        }
    }

    pub(crate) fn is_on(&mut self, t_ns: u64) -> bool {
        self.span_at(t_ns).is_spell
    }

    /// When spell `k` begins.
    fn start_ns(&mut self, k: u64) -> u64 {
        let Fault { at_ns, for_ns, .. } = self.fault;
        let within_ns = match self.fault.again {
            Again::Random { every_ns } if k > 0 => {
                (self.times.at(k) * every_ns.saturating_sub(for_ns) as f64) as u64
            }
            _ => 0,
        };
        let steps_ns = k.saturating_mul(self.fault.step_ns().unwrap_or(0));
        at_ns.saturating_add(steps_ns).saturating_add(within_ns)
    }

    /// Whether the slot at an instant is one of `share` of them.
    pub(super) fn is_hit(&mut self, t_ns: u64, share: f64) -> bool {
        // Draws lie in (0, 1): a share of 0 never hits a slot and a share of 1 always does.
        self.is_on(t_ns) && self.slots.at(2 * (t_ns / SLOT_NS)) < share
    }

    /// The number of the bit that is flipped in the packets of the slot.
    pub(super) fn bit(&mut self, t_ns: u64) -> u32 {
        (self.slots.at(2 * (t_ns / SLOT_NS) + 1) * f64::from(u32::MAX)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Effect;
    use proptest::prelude::*;

    /// All spells up to an instant, one after another.
    fn spells(fault: &Fault, seed: u64, until_ns: u64) -> Vec<(u64, u64)> {
        let mut stream = *b"flt.\0\0\0\0";
        stream[4..].copy_from_slice(&fault.number.to_le_bytes());
        let mut draws = Draws::new(seed, &stream);
        let mut spells = vec![(fault.at_ns, fault.at_ns + fault.for_ns)];
        let (mut span_ns, mut number) = (fault.at_ns, 0);
        loop {
            number += 1;
            let room_ns = match fault.again {
                Again::Never => break,
                Again::Exact { period_ns } => {
                    span_ns += period_ns;
                    0
                }
                Again::Random { every_ns } => {
                    span_ns += every_ns;
                    every_ns - fault.for_ns
                }
            };
            if fault.times.is_some_and(|times| number >= times) || span_ns > until_ns {
                break;
            }
            let start_ns = span_ns + (draws.at(number) * room_ns as f64) as u64;
            spells.push((start_ns, start_ns + fault.for_ns));
        }
        spells
    }

    prop_compose! {
        fn faults()(
            number in 0_u32..50,
            at_ns in 0_u64..3_000,
            for_ns in 1_u64..400,
            more_ns in 0_u64..900,
            kind in 0..3_u8,
            times in prop::option::of(1_u64..30),
        ) -> Fault {
            let step_ns = for_ns + more_ns;
            Fault {
                number, at_ns, for_ns,
                again: match kind {
                    0 => Again::Never,
                    1 => Again::Random { every_ns: step_ns },
                    _ => Again::Exact { period_ns: step_ns },
                },
                times: if kind == 0 { None } else { times },
                effect: Effect::Down,
            }
        }
    }

    proptest! {
        /// Any instants, in any order, against a list of all spells.
        #[test]
        fn an_instant_is_within_a_spell_exactly_if_the_list_of_all_spells_says_so(
            fault in faults(), seed: u64, instants in prop::collection::vec(0_u64..20_000, 1..60),
        ) {
            let all = spells(&fault, seed, 40_000);
            for pair in all.windows(2) {
                prop_assert!(pair[0].1 <= pair[1].0, "they overlap: {pair:?}");
            }
            let mut seeded = Seeded::new(&fault, Way::Up, seed);
            for t_ns in instants {
                let within = all.iter().find(|(start, end)| (*start..*end).contains(&t_ns));
                let span = seeded.span_at(t_ns);
                prop_assert_eq!(span.is_spell, within.is_some());
                let due = match within {
                    Some(spell) => *spell,
                    None => (
                        all.iter().map(|(_, end)| *end).filter(|end| *end <= t_ns).max().unwrap_or(0),
                        all.iter().map(|(start, _)| *start).filter(|start| *start > t_ns).min().unwrap_or(u64::MAX),
                    ),
                };
                prop_assert_eq!((span.start_ns, span.end_ns), due);
            }
        }

        #[test]
        fn both_ways_have_the_same_spells_and_slots_of_their_own(fault in faults(), seed: u64) {
            let [mut up, mut down] = Way::BOTH.map(|way| Seeded::new(&fault, way, seed));
            for t_ns in (0..20_000).step_by(77) {
                prop_assert_eq!(up.span_at(t_ns), down.span_at(t_ns));
            }
            let slots = |seeded: &mut Seeded| (0..64).map(|slot| seeded.bit(slot * SLOT_NS)).collect::<Vec<_>>();
            prop_assert_ne!(slots(&mut up), slots(&mut down));
        }
    }
}
