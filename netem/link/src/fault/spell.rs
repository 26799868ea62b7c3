//! What a profile tells of its faults: their spells in time, and which of them not every player or connection bears.
//!
//! What a fault does to a packet is not here.

use crate::fault::{Effect, Seeded};
use crate::profile::Profile;
use crate::time::LinkTime;
use crate::way::Way;

/// A time during which a fault of a link is in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultSpell {
    /// The direction that it concerns.
    pub way: Way,
    /// When it begins.
    pub start: LinkTime,
    /// When it ends.
    pub end: LinkTime,
    /// Its word in a profile, such as `down`.
    pub word: &'static str,
}

impl Profile {
    /// The spells of all faults under `seed` that overlap the time between two instants of link time, in
    /// order of their beginning.
    #[must_use]
    pub fn faults(&self, seed: u64, from: LinkTime, to: LinkTime) -> Vec<FaultSpell> {
        let mut spells = Vec::new();
        for way in Way::BOTH {
            for fault in &self.law(way).faults {
                let mut seeded = Seeded::new(fault, way, seed);
                let mut t_ns = from.ns();
                while t_ns < to.ns() {
                    let span = seeded.span_at(t_ns);
                    if span.is_spell {
                        spells.push(FaultSpell {
                            way,
                            start: LinkTime::from_ns(span.start_ns),
                            end: LinkTime::from_ns(span.end_ns),
                            word: fault.effect.word(),
                        });
                    }
                    t_ns = span.end_ns;
                }
            }
        }
        spells.sort_by_key(|spell| spell.start);
        spells
    }

    /// The first fault that tc cannot play, by its word.
    #[must_use]
    pub fn beyond_tc(&self) -> Option<&'static str> {
        self.fault_of(|effect| {
            matches!(
                effect,
                Effect::Duplicate { .. } | Effect::Reorder { .. } | Effect::Reset | Effect::Rebind
            )
        })
    }

    /// The first fault that breaks connections of TCP, by its word.
    #[must_use]
    pub fn breaks_connections(&self) -> Option<&'static str> {
        self.fault_of(|effect| matches!(effect, Effect::Reset | Effect::Rebind))
    }

    /// The first fault that makes two packets of one, by its word.
    #[must_use]
    pub fn duplicates(&self) -> Option<&'static str> {
        self.fault_of(|effect| matches!(effect, Effect::Duplicate { .. }))
    }

    fn fault_of(&self, is_it: impl Fn(Effect) -> bool) -> Option<&'static str> {
        let mut effects = Way::BOTH
            .iter()
            .flat_map(|way| &self.law(*way).faults)
            .map(|fault| fault.effect);
        effects.find(|effect| is_it(*effect)).map(Effect::word)
    }
}
