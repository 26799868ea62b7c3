//! What a fault that an experiment asked for did to an end: what it excuses, and whether it was the one asked for.
//!
//! Within its time nothing that waits is late. After it, an end has to catch up. That the link was no quicker than
//! it should be counts at any time.

use std::ops::Range;

use plan::{Disturbance, End, EndEffect, EndFaultDone};

use crate::limit::{CAUGHT_UP_SHARE, DRAIN_MS, DRAIN_SHARE, HIT_LATE_MS, HIT_SHARE, UNWRITTEN_MS};
use crate::machine::describe;
use crate::milliseconds::{ms, ns};
use crate::still::Times;

/// The times at which faults hit the ends, monotonic.
#[derive(Debug, Clone, Default)]
pub struct Hits {
    /// What messages meet: from a hit's beginning until its end has caught up.
    messages: Times,
    /// When the controller stands still, or is busy with what piled up while an end did.
    controller: Times,
    /// When the plant stands still, or catches up.
    plant: Times,
    /// When an end is killed and ready again: its connections are gone.
    kills: Vec<Range<u64>>,
    /// When the plant may not have written its rows before it was killed.
    unwritten: Times,
}

impl Hits {
    /// The hits of a run. `message_share` is the share of h that its client takes to read an answer.
    #[must_use]
    pub fn of(done: &[EndFaultDone], message_share: f64) -> Hits {
        let drained_ns = |one: &EndFaultDone| {
            let stood_ns = one.to_ns.saturating_sub(one.from_ns) as f64;
            one.to_ns + ns(DRAIN_MS) + (stood_ns * (DRAIN_SHARE + message_share)) as u64
        };
        let caught_up_ns = |one: &EndFaultDone| {
            let stood_ns = one.to_ns.saturating_sub(one.from_ns) as f64;
            one.to_ns + (CAUGHT_UP_SHARE * stood_ns) as u64
        };
        let controller = done.iter().map(|one| match one.end {
            End::Controller => one.from_ns..drained_ns(one),
            End::Plant => one.to_ns..drained_ns(one),
        });
        let plants = done.iter().filter(|one| one.end == End::Plant);
        let kills = done.iter().filter(|one| one.effect == EndEffect::Kill);
        Hits {
            messages: done
                .iter()
                .map(|one| one.from_ns..drained_ns(one))
                .collect(),
            controller: controller.collect(),
            plant: plants.map(|one| one.from_ns..caught_up_ns(one)).collect(),
            kills: kills.clone().map(|one| one.from_ns..one.to_ns).collect(),
            unwritten: kills
                .filter(|one| one.end == End::Plant)
                .map(|one| one.from_ns.saturating_sub(ns(UNWRITTEN_MS))..one.from_ns)
                .collect(),
        }
    }

    /// Whether a message between these instants may have met a hit.
    pub(crate) fn meets(&self, from_ns: u64, to_ns: u64) -> bool {
        self.messages.within_ns(from_ns, to_ns) > 0
    }

    /// The last instant up to `t_ns` at which a kill may have broken connections.
    pub(crate) fn broken_ns(&self, t_ns: u64) -> Option<u64> {
        let begun = self.kills.iter().filter(|kill| kill.start <= t_ns);
        begun.map(|kill| kill.end.min(t_ns)).max()
    }

    /// Whether a hit explains that a deadline of the controller is late or missed.
    pub(crate) fn excuses_deadline(&self, t_ns: u64) -> bool {
        self.controller.contains(t_ns)
    }

    /// Whether the plant may have lost its row of this instant, because it was killed.
    pub(crate) fn loses_row(&self, t_ns: u64) -> bool {
        self.unwritten.contains(t_ns)
    }

    /// How long a hit kept the plant from a tick between these instants, ns.
    pub(crate) fn kept_ns(&self, from_ns: u64, to_ns: u64) -> u64 {
        self.plant.within_ns(from_ns, to_ns)
    }
}

/// Finds the first fault that was not done as asked: it is another experiment then.
#[must_use]
pub(crate) fn off(done: &[EndFaultDone], from_ns: u64) -> Option<Disturbance> {
    done.iter().find_map(|one| {
        let late_ms = ms(one.from_ns) - ms(one.asked_from_ns);
        let asked_ms = ms(one.asked_to_ns) - ms(one.asked_from_ns);
        let stood_ms = ms(one.stood_ns);
        let due_ms = match one.effect {
            // How long an end takes to start is its own, and a loop may end before a load does.
            EndEffect::Kill | EndEffect::Busy(_) => stood_ms,
            EndEffect::Freeze => asked_ms,
            EndEffect::Starve(share) => asked_ms * share,
        };
        let is_off = late_ms > HIT_LATE_MS
            || stood_ms > due_ms * (1.0 + HIT_SHARE) + HIT_LATE_MS
            || stood_ms < due_ms * (1.0 - HIT_SHARE) - HIT_LATE_MS;
        is_off.then(|| {
            describe(
                &one.end.to_string(),
                one.from_ns,
                from_ns,
                stood_ms,
                format!(
                    "the fault did not hit the {} as asked: it came {late_ms:.0} ms late and held it up for \
                     {stood_ms:.0} of {due_ms:.0} ms (limit {HIT_LATE_MS:.0} ms and {:.0} %)",
                    one.end,
                    100.0 * HIT_SHARE
                ),
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn done(end: End, effect: EndEffect, from_ms: u64, to_ms: u64) -> EndFaultDone {
        EndFaultDone {
            end,
            effect,
            asked_from_ns: 2000 * MS,
            asked_to_ns: 2500 * MS,
            from_ns: from_ms * MS,
            to_ns: to_ms * MS,
            stood_ns: (to_ms - from_ms) * MS,
        }
    }

    #[test]
    fn a_hit_excuses_what_waits_for_it_and_nothing_before_or_long_after() {
        let hits = Hits::of(&[done(End::Plant, EndEffect::Freeze, 2000, 2500)], 0.0);
        assert_eq!(hits.kept_ns(1990 * MS, 2010 * MS), 10 * MS);
        assert_eq!(hits.kept_ns(1000 * MS, 2000 * MS), 0);
        assert!(!hits.meets(1900 * MS, 1999 * MS) && hits.meets(1900 * MS, 2001 * MS));
        assert!(hits.meets(2600 * MS, 2601 * MS) && !hits.meets(2700 * MS, 2800 * MS));
        // A controller sends while the plant stands still; afterwards it has answers to read.
        assert!(!hits.excuses_deadline(2400 * MS) && hits.excuses_deadline(2510 * MS));
        let hits = Hits::of(&[done(End::Controller, EndEffect::Kill, 2000, 2600)], 0.0);
        assert!(hits.excuses_deadline(2400 * MS) && !hits.excuses_deadline(1999 * MS));
        assert_eq!(hits.kept_ns(0, u64::MAX), 0);
        assert_eq!(hits.broken_ns(1000 * MS), None);
        assert_eq!(hits.broken_ns(2100 * MS), Some(2100 * MS));
        assert_eq!(hits.broken_ns(9000 * MS), Some(2600 * MS));
    }

    #[test]
    fn a_fault_that_came_late_or_was_short_is_another_one() {
        let is_off = |one: EndFaultDone| off(&[one], 0).is_some();
        assert!(!is_off(done(End::Plant, EndEffect::Freeze, 2001, 2502)));
        assert!(is_off(done(End::Plant, EndEffect::Freeze, 2040, 2500)));
        assert!(is_off(done(End::Plant, EndEffect::Freeze, 2000, 2300)));
        assert!(is_off(done(End::Plant, EndEffect::Freeze, 2000, 2700)));
        assert!(!is_off(done(End::Plant, EndEffect::Kill, 2000, 2700)));
    }
}
