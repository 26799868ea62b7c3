//! Matches messages, answers and ticks: which y a command follows from, and when it took effect.

use std::collections::BTreeMap;
use std::ops::Range;

use endpoint::{MessageOutcome, MessageRow, TickRow};
use link::{Timeline, Way};

use super::{Budget, Crossing, Part, Sample, Trip, between};
use crate::numbered::Numbered;

/// When the plant ticked, and when each command took effect.
#[derive(Debug, Default)]
struct Ticks {
    /// The instant of each tick, ns, by its number.
    t_ns: Vec<u64>,
    /// When a command became the plant's input, ns, with its number.
    effects_ns: Vec<(u64, u64)>,
    newest: Option<u64>,
}

impl Ticks {
    fn of(rows: &[TickRow]) -> Ticks {
        let mut ticks = Ticks::default();
        ticks.t_ns.reserve_exact(rows.len());
        rows.iter().for_each(|row| ticks.push(row));
        ticks
    }

    fn push(&mut self, row: &TickRow) {
        self.t_ns.push(row.t_tick_ns);
        if let Some(seq) = row.seq.filter(|_| row.seq != self.newest) {
            self.newest = row.seq;
            self.effects_ns.push((seq, row.t_tick_ns));
        }
    }

    fn at(&self, k: u64) -> Option<u64> {
        usize::try_from(k)
            .ok()
            .and_then(|k| self.t_ns.get(k))
            .copied()
    }
}

/// The answer from which a command follows.
#[derive(Debug, Clone, Copy)]
struct Known {
    tick: u64,
    t_arrive_ns: u64,
    t_receive_ns: u64,
    down: Crossing,
}

/// Matches messages with the answers that were known when they were sent, and with the ticks that took them.
/// The link comes with the lengths of a message's packets up and down, which matter if it has a rate limit.
pub(super) fn of_rows(
    messages: &[MessageRow],
    arrived: &Numbered<u64>,
    ticks: &[TickRow],
    link: Option<(Timeline, [u32; 2])>,
) -> Budget {
    let ticks = Ticks::of(ticks);
    // When each command was first the plant's input.
    let effect_ns: Numbered<u64> = ticks.effects_ns.iter().copied().collect();
    let mut budget = Budget {
        effect_ns: effect_ns.values().min().copied(),
        ..Budget::default()
    };
    let mut sent: Vec<&MessageRow> = Vec::with_capacity(messages.len());
    for row in messages {
        match (row.outcome, row.t_send_ns) {
            (MessageOutcome::Missed, _) => budget.missed_ns.push(row.t_due_ns),
            (_, None) => {}
            (_, Some(_)) => sent.push(row),
        }
    }
    sent.sort_by_cached_key(|row| (row.t_send_ns, row.seq));
    let arrive_ns = |row: &MessageRow| row.t_arrive_ns.or_else(|| arrived.get(row.seq).copied());
    // A timeline forgets what lies far behind its newest query: one for each way, asked in order.
    let mut way_up = Share::of(Way::Up, link.clone());
    let (downs, known) = answers(&sent, arrive_ns, Share::of(Way::Down, link));
    let mut known = known.into_iter().peekable();
    let mut newest: Option<Known> = None;
    for row in &sent {
        let Some(t_send_ns) = row.t_send_ns else {
            continue;
        };
        // As the controller keeps them: the newest by the plant's tick, since answers may overtake.
        while let Some(next) = known.next_if(|next| next.t_receive_ns <= t_send_ns) {
            if newest.is_none_or(|newest| next.tick > newest.tick) {
                newest = Some(next);
            }
        }
        let Some(t_arrive_ns) = arrive_ns(row) else {
            budget.lost_ns.push(t_send_ns);
            continue;
        };
        let trip = Trip {
            seq: row.seq,
            t_due_ns: row.t_due_ns,
            t_send_ns,
            up: way_up.crossing(t_send_ns, t_arrive_ns),
            down: downs.get(&row.seq).copied(),
        };
        budget.trips.push(trip);
        let sample = newest.and_then(|newest| {
            let measured_ns = ticks.at(newest.tick)?;
            let effect_ns = *effect_ns.get(row.seq)?;
            sample(row, &trip, t_arrive_ns, &newest, &(measured_ns..effect_ns))
        });
        budget.samples.extend(sample);
    }
    budget
}

/// The ways down of all answers, by the number of their message, and those answers that bring a y, in the order of
/// their receipt.
fn answers(
    sent: &[&MessageRow],
    arrive_ns: impl Fn(&MessageRow) -> Option<u64>,
    mut way_down: Share,
) -> (BTreeMap<u64, Crossing>, Vec<Known>) {
    let mut answers: Vec<(u64, &MessageRow)> = sent
        .iter()
        .filter_map(|row| Some((arrive_ns(row)?, *row)))
        .filter(|(_, row)| row.t_receive_ns.is_some())
        .collect();
    answers.sort_by_key(|(t_arrive_ns, _)| *t_arrive_ns);
    let downs: BTreeMap<u64, Crossing> = answers
        .iter()
        .filter_map(|(t_arrive_ns, row)| {
            Some((row.seq, way_down.crossing(*t_arrive_ns, row.t_receive_ns?)))
        })
        .collect();
    let mut known: Vec<Known> = answers
        .iter()
        .filter_map(|(t_arrive_ns, row)| {
            Some(Known {
                tick: row.tick?,
                t_arrive_ns: *t_arrive_ns,
                t_receive_ns: row.t_receive_ns?,
                down: *downs.get(&row.seq)?,
            })
        })
        .collect();
    known.sort_by_key(|one| one.t_receive_ns);
    (downs, known)
}

/// The sample of a command, from the tick that measured its y to the one that took it; `None` if it has no y. A command
/// has no sample that never took effect, as when a newer one came before the tick.
fn sample(
    row: &MessageRow,
    trip: &Trip,
    t_arrive_ns: u64,
    of: &Known,
    whole_ns: &Range<u64>,
) -> Option<Sample> {
    row.y?;
    let ready_ns = trip.t_due_ns.clamp(of.t_receive_ns, trip.t_send_ns);
    let mut parts_ns = [0; 8];
    for (part, ns) in [
        (Part::Read, between(whole_ns.start, of.t_arrive_ns)),
        (Part::Answer, of.down.ends_ns),
        (Part::Down, of.down.link_ns),
        (Part::Law, between(of.t_receive_ns, ready_ns)),
        (Part::Client, between(ready_ns, trip.t_send_ns)),
        (Part::Up, trip.up.link_ns),
        (Part::Request, trip.up.ends_ns),
        (Part::Tick, between(t_arrive_ns, whole_ns.end)),
    ] {
        parts_ns[part as usize] = ns;
    }
    Some(Sample {
        seq: row.seq,
        t_due_ns: row.t_due_ns,
        parts_ns,
    })
}

/// What a link has of one way.
struct Share {
    way: Way,
    link: Option<(Timeline, [u32; 2])>,
}

impl Share {
    fn of(way: Way, link: Option<(Timeline, [u32; 2])>) -> Share {
        Share { way, link }
    }

    /// A way from one instant to another. Must be asked in order of `from_ns`.
    fn crossing(&mut self, from_ns: u64, to_ns: u64) -> Crossing {
        let whole_ns = between(from_ns, to_ns);
        let of_link = self.link.as_mut().map_or(0, |(link, bytes)| {
            let passage = link.passage(self.way, from_ns, bytes[self.way as usize]);
            i64::try_from(passage.delay_ns).unwrap_or(i64::MAX)
        });
        let link_ns = of_link.min(whole_ns.max(0));
        Crossing {
            link_ns,
            ends_ns: whole_ns - link_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message(seq: u64, due: u64, send: u64, receive: u64, arrive: u64, tick: u64) -> MessageRow {
        MessageRow {
            seq,
            t_due_ns: due,
            t_send_ns: Some(send),
            t_receive_ns: Some(receive),
            t_arrive_ns: Some(arrive),
            r: 1.0,
            y: Some(0.0),
            e: Some(1.0),
            u: Some(1.0),
            tick: Some(tick),
            outcome: MessageOutcome::Answered,
            y_seq: None,
        }
    }

    fn no_arrivals() -> Numbered<u64> {
        [].into_iter().collect()
    }

    fn ticks(rows: &[(u64, Option<u64>)]) -> Vec<TickRow> {
        let mut ticks = Vec::new();
        for (k, (t_tick_ns, seq)) in (0..).zip(rows) {
            ticks.push(TickRow {
                k,
                t_due_ns: *t_tick_ns,
                t_tick_ns: *t_tick_ns,
                u: 0.0,
                y: 0.0,
                seq: *seq,
                u_applied: None,
            });
        }
        ticks
    }

    #[test]
    fn a_command_follows_from_the_newest_tick_that_was_known_when_it_was_sent() {
        // Message 1 overtakes message 0's answer; message 2 is sent when both are known.
        let rows = vec![
            message(0, 0, 5, 90, 20, 0),
            message(1, 30, 31, 60, 45, 1),
            message(2, 95, 100, 140, 120, 2),
        ];
        let ticks = ticks(&[(10, None), (40, Some(0)), (80, Some(1)), (125, Some(2))]);
        let budget = of_rows(&rows, &no_arrivals(), &ticks, None);
        assert_eq!(budget.trips.len(), 3);
        // Nothing was known when 0 and 1 were sent.
        let [sample] = budget.samples[..] else {
            panic!("{budget:?}")
        };
        // Measured at tick 1 (40), read at 45, known at 60, due at 95, sent at 100, there at 120, in
        // effect at 125.
        assert_eq!(sample.parts_ns, [5, 15, 0, 35, 5, 0, 20, 5]);
        assert_eq!(sample.total_ns(), 125 - 40);
    }

    #[test]
    fn what_was_not_sent_or_never_arrived_is_told() {
        let mut missed = message(0, 7, 0, 0, 0, 0);
        (missed.outcome, missed.t_send_ns) = (MessageOutcome::Missed, None);
        let mut lost = message(1, 10, 11, 0, 0, 0);
        (lost.outcome, lost.t_arrive_ns, lost.t_receive_ns) = (MessageOutcome::Timeout, None, None);
        let budget = of_rows(&[missed, lost], &no_arrivals(), &ticks(&[]), None);
        assert_eq!((budget.missed_ns, budget.lost_ns), (vec![7], vec![11]));
        assert_eq!((budget.trips, budget.samples), (vec![], vec![]));
    }

    proptest! {
        #[test]
        fn the_parts_are_the_round_trip_and_the_sample_whatever_the_link(
            steps in prop::collection::vec((1u64..9_000_000, 1u64..9_000_000, 1u64..9_000_000), 2..40),
            seed in any::<u64>(),
        ) {
            let profile = link::Profile::builtin("couva").expect("built in");
            let (profile, _) = link::Profile::read(profile, "couva", &|_| Err(String::new()));
            let epoch = link::Epoch::at_ns(0);
            let link = Timeline::new(&profile.expect("valid"), seed, epoch);
            let (mut rows, mut at) = (Vec::new(), Vec::new());
            for (seq, (late, up, down)) in (0u64..).zip(&steps) {
                let due = seq * 5_000_000;
                let arrive = due + late + up;
                rows.push(message(seq, due, due + late, arrive + down, arrive, seq));
                at.push((due, seq.checked_sub(3)));
            }
            let budget = of_rows(&rows, &no_arrivals(), &ticks(&at), Some((link, [150; 2])));
            prop_assert_eq!(budget.trips.len(), rows.len());
            for trip in &budget.trips {
                let row = rows[trip.seq as usize];
                let whole = row.t_receive_ns.zip(row.t_send_ns).map(|(to, from)| between(from, to));
                prop_assert_eq!(trip.round_trip_ns(), whole);
            }
            for sample in &budget.samples {
                let effect = (sample.seq + 3) * 5_000_000;
                let measured = effect.cast_signed() - sample.total_ns();
                // The whole begins at one of the ticks.
                prop_assert_eq!(measured.rem_euclid(5_000_000), 0);
            }
        }
    }
}
