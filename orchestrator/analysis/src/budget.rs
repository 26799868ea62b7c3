//! The delay budget of a sample: from the tick at which y was measured to the tick at which the u that
//! follows from it took effect, part by part; and the round trip of each message in its parts.
//!
//! Everything is a difference of stamps in the rows, in whole nanoseconds, so the parts add up exactly.
//! Only the link's share of a way is not stamped: it is what the link had at the instant of sending, by
//! its profile and seed; what the way took beyond that is the ends' own: processes, kernel, and what was
//! sent again.

use std::collections::BTreeMap;

use endpoint::{ArrivalRow, MessageOutcome, MessageRow, TickRow};
use link::{Timeline, Way};
use plan::{Plan, file_name};

use crate::campaign::Run;
use crate::rows::{ReadError, read};

/// Length of the packet with which the link's share is asked, in bytes: that of a message of webloop's
/// own client. It matters to links with a rate limit alone.
const MESSAGE_BYTES: u32 = 150;

/// A part of a sample's delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// From the plant's tick to the arrival of the message whose answer carries its y.
    Read,
    /// From that arrival to the answer's, without the link's share.
    Answer,
    /// The link's share of the way down.
    Down,
    /// From the answer to the next deadline of the controller, or to the sending, if that is after it.
    Law,
    /// From the deadline to the sending of the command.
    Client,
    /// The link's share of the way up.
    Up,
    /// The rest of the way up.
    Request,
    /// From the command's arrival to the plant's next tick, which takes it.
    Tick,
}

impl Part {
    /// All parts, in the order in which a sample meets them.
    pub const ALL: [Part; 8] = [
        Part::Read,
        Part::Answer,
        Part::Down,
        Part::Law,
        Part::Client,
        Part::Up,
        Part::Request,
        Part::Tick,
    ];

    /// Its name: `y waits to be read`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Part::Read => "y waits to be read",
            Part::Answer => "answer, ends",
            Part::Down => "link down",
            Part::Law => "waits for the deadline",
            Part::Client => "client late",
            Part::Up => "link up",
            Part::Request => "request, ends",
            Part::Tick => "u waits for the tick",
        }
    }

    /// Whether it is the link's.
    #[must_use]
    pub fn is_link(self) -> bool {
        matches!(self, Part::Up | Part::Down)
    }
}

/// A command that took effect, with the delay of the y from which it follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// The command's number.
    pub seq: u64,
    /// When it was due, ns.
    pub t_due_ns: u64,
    /// The parts, ns, in the order of [`Part::ALL`]. A part may be a little below zero where two threads
    /// stamp what happens at once.
    pub parts_ns: [i64; 8],
}

impl Sample {
    /// From measurement to effect, ns.
    #[must_use]
    pub fn total_ns(&self) -> i64 {
        self.parts_ns.iter().sum()
    }

    /// One of its parts, ns.
    #[must_use]
    pub fn part_ns(&self, part: Part) -> i64 {
        self.parts_ns[part as usize]
    }
}

/// One way of a message, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crossing {
    /// The link's share: at most the whole.
    pub link_ns: i64,
    /// The rest.
    pub ends_ns: i64,
}

impl Crossing {
    /// The whole way, ns.
    #[must_use]
    pub fn ns(self) -> i64 {
        self.link_ns + self.ends_ns
    }
}

/// A message that reached the plant, in the order of sending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trip {
    /// Its number.
    pub seq: u64,
    /// When it was due, ns.
    pub t_due_ns: u64,
    /// When it was sent, ns.
    pub t_send_ns: u64,
    /// Up, from sending to arrival.
    pub up: Crossing,
    /// Down, from arrival to the answer; `None` without one.
    pub down: Option<Crossing>,
}

impl Trip {
    /// How late it was sent, ns.
    #[must_use]
    pub fn client_ns(&self) -> i64 {
        between(self.t_due_ns, self.t_send_ns)
    }

    /// Its round trip, ns; `None` without an answer.
    #[must_use]
    pub fn round_trip_ns(&self) -> Option<i64> {
        Some(self.up.ns() + self.down?.ns())
    }
}

/// The messages of a run in their parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Budget {
    /// When the controller's first message was due, ns: the origin of times in figures.
    pub start_ns: u64,
    /// When the first command took effect, ns: the start of the step response.
    pub effect_ns: Option<u64>,
    /// The messages that reached the plant.
    pub trips: Vec<Trip>,
    /// The commands that took effect; none in open loop.
    pub samples: Vec<Sample>,
    /// When each message was due that was not sent, ns.
    pub missed_ns: Vec<u64>,
    /// When each message was sent that never arrived, ns.
    pub lost_ns: Vec<u64>,
}

impl Budget {
    /// Reads a run's rows and asks its link.
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn of(run: &Run, plan: &Plan) -> Result<Budget, ReadError> {
        let path = |name: &str| run.folder.join(name);
        let mut messages: Vec<MessageRow> = Vec::new();
        read(&path(file_name::MESSAGES), MessageRow::COLUMNS, |row| {
            messages.push(*row);
        })?;
        // Of a command that came twice, the first counts.
        let mut arrived: BTreeMap<u64, u64> = BTreeMap::new();
        read(
            &path(file_name::ARRIVALS),
            ArrivalRow::COLUMNS,
            |row: &ArrivalRow| {
                arrived.entry(row.seq).or_insert(row.t_arrive_ns);
            },
        )?;
        let mut ticks = Ticks::default();
        read(&path(file_name::TICKS), TickRow::COLUMNS, |row| {
            ticks.push(row);
        })?;
        let start_ns = run
            .manifest
            .as_ref()
            .map_or(0, |manifest| manifest.start_ns);
        Ok(Budget {
            start_ns,
            effect_ns: ticks.effect_ns.values().min().copied(),
            ..of_rows(messages, &arrived, &ticks, timeline(run, plan))
        })
    }

    /// The median of each part over the samples, ns, in the order of [`Part::ALL`]; `None` without one.
    #[must_use]
    pub fn medians_ns(&self) -> Option<[i64; 8]> {
        let middle = |part: Part| {
            let mut values: Vec<i64> = self.samples.iter().map(|one| one.part_ns(part)).collect();
            values.sort_unstable();
            values.get(values.len() / 2).copied()
        };
        let mut medians = [0; 8];
        for part in Part::ALL {
            medians[part as usize] = middle(part)?;
        }
        Some(medians)
    }
}

/// The link of a run as it met it; `None` if the run or its profile is not known well enough to say.
#[must_use]
pub fn timeline(run: &Run, plan: &Plan) -> Option<Timeline> {
    let manifest = run.manifest.as_ref()?;
    let profile = plan.profiles.get(&run.cell.topology)?;
    let profile = profile.profile(&run.cell.topology).ok()?;
    Some(Timeline::new(&profile, run.cell.link_seed, manifest.epoch))
}

/// When the plant ticked, and when each command took effect.
#[derive(Debug, Default)]
struct Ticks {
    /// The instant of each tick, ns, by its number.
    t_ns: Vec<u64>,
    /// When a command was first the plant's input, ns, by its number.
    effect_ns: BTreeMap<u64, u64>,
    newest: Option<u64>,
}

impl Ticks {
    fn push(&mut self, row: &TickRow) {
        self.t_ns.push(row.t_tick_ns);
        if let Some(seq) = row.seq.filter(|_| row.seq != self.newest) {
            self.newest = row.seq;
            self.effect_ns.entry(seq).or_insert(row.t_tick_ns);
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

fn of_rows(
    messages: Vec<MessageRow>,
    arrived: &BTreeMap<u64, u64>,
    ticks: &Ticks,
    link: Option<Timeline>,
) -> Budget {
    let mut budget = Budget::default();
    let mut sent = messages;
    sent.retain(|row| match (row.outcome, row.t_send_ns) {
        (MessageOutcome::Missed, _) => {
            budget.missed_ns.push(row.t_due_ns);
            false
        }
        (_, None) => false,
        (_, Some(_)) => true,
    });
    sent.sort_by_key(|row| (row.t_send_ns, row.seq));
    let arrive_ns = |row: &MessageRow| row.t_arrive_ns.or_else(|| arrived.get(&row.seq).copied());
    // A timeline forgets what lies far behind its newest query: one for each way, asked in order.
    let mut way_up = Share::of(Way::Up, link.clone());
    let mut way_down = Share::of(Way::Down, link);
    let mut answers: Vec<(u64, &MessageRow)> = sent
        .iter()
        .filter_map(|row| Some((arrive_ns(row)?, row)))
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
        budget
            .samples
            .extend(newest.and_then(|newest| sample(row, &trip, t_arrive_ns, &newest, ticks)));
    }
    budget
}

/// The sample of a command; `None` if it never took effect, as when a newer one came before the tick.
fn sample(
    row: &MessageRow,
    trip: &Trip,
    t_arrive_ns: u64,
    of: &Known,
    ticks: &Ticks,
) -> Option<Sample> {
    row.y?;
    let effect_ns = *ticks.effect_ns.get(&row.seq)?;
    let measured_ns = ticks.at(of.tick)?;
    let ready_ns = trip.t_due_ns.clamp(of.t_receive_ns, trip.t_send_ns);
    let mut parts_ns = [0; 8];
    for (part, ns) in [
        (Part::Read, between(measured_ns, of.t_arrive_ns)),
        (Part::Answer, of.down.ends_ns),
        (Part::Down, of.down.link_ns),
        (Part::Law, between(of.t_receive_ns, ready_ns)),
        (Part::Client, between(ready_ns, trip.t_send_ns)),
        (Part::Up, trip.up.link_ns),
        (Part::Request, trip.up.ends_ns),
        (Part::Tick, between(t_arrive_ns, effect_ns)),
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
    link: Option<Timeline>,
}

impl Share {
    fn of(way: Way, link: Option<Timeline>) -> Share {
        Share { way, link }
    }

    /// A way from one instant to another. Must be asked in order of `from_ns`.
    fn crossing(&mut self, from_ns: u64, to_ns: u64) -> Crossing {
        let whole_ns = between(from_ns, to_ns);
        let of_link = self.link.as_mut().map_or(0, |link| {
            let passage = link.passage(self.way, from_ns, MESSAGE_BYTES);
            i64::try_from(passage.delay_ns).unwrap_or(i64::MAX)
        });
        let link_ns = of_link.min(whole_ns.max(0));
        Crossing {
            link_ns,
            ends_ns: whole_ns - link_ns,
        }
    }
}

/// Time from one stamp to another, ns.
fn between(from_ns: u64, to_ns: u64) -> i64 {
    to_ns.wrapping_sub(from_ns).cast_signed()
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
        }
    }

    fn ticks(rows: &[(u64, Option<u64>)]) -> Ticks {
        let mut ticks = Ticks::default();
        for (k, (t_tick_ns, seq)) in (0..).zip(rows) {
            ticks.push(&TickRow {
                k,
                t_due_ns: *t_tick_ns,
                t_tick_ns: *t_tick_ns,
                u: 0.0,
                y: 0.0,
                seq: *seq,
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
        let budget = of_rows(rows, &BTreeMap::new(), &ticks, None);
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
        let budget = of_rows(vec![missed, lost], &BTreeMap::new(), &ticks(&[]), None);
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
            let budget = of_rows(rows.clone(), &BTreeMap::new(), &ticks(&at), Some(link));
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
