//! The controller's deadlines and commands, replayed from the outputs that its answers brought.

use std::collections::BTreeMap;

use control::{AnswerFacts, Law, LawInput, Moment, Signals, seconds};
use endpoint::{
    ArrivalOutcome, ArrivalRow, Integrate, Late, MessageRow, Mode, Reference, Schedule,
};
use plan::End;

use super::plant::Plant;
use super::{Both, Other, differs, is_same};

/// How far a page's stamps and deadlines may be off by their rounding, ns.
const PAGE_NS: u64 = 100_000;

/// An answer whose stamp is a little later than the stamp of a command may have been read before it, ns.
const READ_NS: u64 = 2_000_000;

/// How far a command may be off that depends on the elapsed time, which a page measures finer than it is stamped, as
/// a share of it and of 1.
const ELAPSED_SHARE: f64 = 1e-6;

/// Replays all deadlines; returns how many commands agreed, and the first row that does not.
pub(super) fn replay(both: &Both<'_>, plant: &Plant) -> (u64, Option<Other>) {
    let Ok((law, _)) = both.system.law_at(both.cell.settings.h) else {
        return (0, None);
    };
    let mut rows: Vec<&MessageRow> = both.messages.iter().collect();
    rows.sort_by_key(|row| row.seq);
    let mut end = Controller {
        both,
        plant,
        reference: both.cell.moving_reference(),
        answers: Answers::of(both),
        last: None,
        arrived: both.arrivals.iter().map(|row| (row.seq, row.u)).collect(),
        rows: rows.clone(),
        held: if law.measures_age() {
            HeldCommands::of(both.arrivals)
        } else {
            HeldCommands::default()
        },
        law,
        sent: BTreeMap::new(),
        commands: 0,
    };
    let until_ns = both
        .until_ns(End::Controller)
        .min(plant.unknown_from_ns.unwrap_or(u64::MAX));
    for (seq, row) in (0..).zip(rows) {
        // A row that is missing is found elsewhere, and the law's state after it is not known.
        if row.seq != seq || row.t_due_ns >= until_ns {
            break;
        }
        if let Some(what) = end.step(row) {
            let row = format!("messages.csv, seq = {seq}");
            let other = Other {
                end: End::Controller,
                row,
                what,
            };
            return (end.commands, Some(other));
        }
    }
    (end.commands, None)
}

struct Controller<'a> {
    both: &'a Both<'a>,
    plant: &'a Plant,
    reference: Option<Reference>,
    answers: Answers,
    /// The row before, and when its command was sent, or the last that was.
    last: Option<(u64, Option<u64>)>,
    law: Law,
    /// The first input of each command that arrived.
    arrived: BTreeMap<u64, f64>,
    /// In order of their numbers.
    rows: Vec<&'a MessageRow>,
    held: HeldCommands,
    /// The commands so far, with both inputs.
    sent: BTreeMap<u64, Signals>,
    commands: u64,
}

impl<'a> Controller<'a> {
    /// Replays a deadline; returns how it differs.
    fn step(&mut self, row: &MessageRow) -> Option<String> {
        let sent_ns = self.last.and_then(|(_, sent_ns)| sent_ns);
        let off = self
            .off_schedule(row)
            .or_else(|| self.off_reference(row))
            .or_else(|| self.off_command(row, sent_ns));
        self.last = Some((row.t_due_ns, row.t_send_ns.or(sent_ns)));
        off
    }

    fn rounding_ns(&self) -> u64 {
        match self.both.cell.client.is_browser() {
            true => PAGE_NS,
            false => 0,
        }
    }

    /// Whether the deadline is none of the plan's h.
    fn off_schedule(&self, row: &MessageRow) -> Option<String> {
        let settings = &self.both.cell.settings;
        let h_ns = settings.h.ns();
        let off_ns = self.rounding_ns();
        let grid_ns = self
            .both
            .start_ns
            .saturating_add(row.seq.saturating_mul(h_ns));
        let is_off = match (settings.schedule, self.last) {
            (Schedule::Absolute, _) | (_, None) => row.t_due_ns.abs_diff(grid_ns) > off_ns,
            // The next is due h after the last was sent, or has ended.
            (_, Some((due_ns, _))) => {
                row.t_due_ns.saturating_add(off_ns) < due_ns.saturating_add(h_ns)
            }
        };
        is_off.then(|| {
            format!(
                "t_due_ns is {}; the plan's h is {}",
                row.t_due_ns, settings.h
            )
        })
    }

    fn off_reference(&self, row: &MessageRow) -> Option<String> {
        let since_ns = row.t_due_ns.saturating_sub(self.both.start_ns);
        let r = |since_ns: u64| match &self.reference {
            Some(moving) => moving.at(since_ns),
            None => self.both.cell.settings.r,
        };
        let off_ns = self.rounding_ns();
        let near = [
            since_ns.saturating_sub(off_ns),
            since_ns.saturating_add(off_ns),
        ];
        let is_near = near.into_iter().any(|near_ns| is_same(row.r, r(near_ns)));
        (!is_near)
            .then(|| differs("r", row.r, r(since_ns)))
            .flatten()
    }

    fn off_command(&mut self, row: &MessageRow, last_sent_ns: Option<u64>) -> Option<String> {
        let (Some(sent_ns), Some(u)) = (row.t_send_ns, row.u) else {
            return None;
        };
        let settings = &self.both.cell.settings;
        let due = match settings.mode {
            Mode::Open => row.r.into(),
            Mode::Closed => {
                let Some(y) = self.output(row, sent_ns) else {
                    let y = row.y.unwrap_or_default();
                    return Some(format!(
                        "y is {y:?}, which no answer brought that came by then"
                    ));
                };
                let h_s = settings.h.seconds();
                let dt_s = match (settings.integrate, last_sent_ns) {
                    (Integrate::Elapsed, Some(last_ns)) => seconds(sent_ns.saturating_sub(last_ns)),
                    _ => h_s,
                };
                let times = self.times(row, sent_ns);
                self.law.update(row.r, LawInput { y, times }, dt_s)
            }
        };
        if self.law.measures_age() {
            self.sent.insert(row.seq, due);
        }
        let is_rounded =
            self.both.cell.client.is_browser() && settings.integrate == Integrate::Elapsed;
        let off = ELAPSED_SHARE * (1.0 + due.first.abs());
        if !(is_rounded && (u - due.first).abs() <= off)
            && let Some(off) = differs("u", u, due.first)
        {
            return Some(off);
        }
        if let Some(arrived) = self.arrived.get(&row.seq)
            && let Some(off) = differs("u as it arrived", *arrived, u)
        {
            return Some(off);
        }
        self.commands += 1;
        None
    }

    /// The row of a message, if none is missing before it.
    fn row(&self, seq: u64) -> Option<&'a MessageRow> {
        let row = self.rows.get(usize::try_from(seq).ok()?)?;
        (row.seq == seq).then_some(*row)
    }

    /// What the law has beside the outputs; only one that measures their age is asked, since older rows do not say
    /// which answer brought them.
    fn times(&self, row: &MessageRow, send_ns: u64) -> Option<Moment> {
        if !self.law.measures_age() {
            return None;
        }
        let brought = row.y_seq.and_then(|seq| self.row(seq));
        let told = brought.and_then(|brought| {
            let t_arrive_ns = brought.t_arrive_ns?;
            let held = self.held.after(brought.seq, t_arrive_ns);
            let rest = Signals::zeros(self.law.signals().1);
            Some(AnswerFacts {
                tick: brought.tick?,
                u: held
                    .and_then(|seq| self.sent.get(&seq))
                    .copied()
                    .unwrap_or(rest),
                send_ns: brought.t_send_ns?,
            })
        });
        Some(Moment { send_ns, told })
    }

    /// The outputs from which a command follows: those of a tick whose answer it had, if the row's first output is
    /// that tick's; `None` if no answer brought it by then.
    fn output(&mut self, row: &MessageRow, sent_ns: u64) -> Option<Signals> {
        let y = row.y.unwrap_or_default();
        if self.plant.shown.is_empty() {
            return Some(y.into());
        }
        let is_it = |shown: &Signals| is_same(shown.first, y);
        if let Some(brought) = row.y_seq.and_then(|seq| self.row(seq))
            && let Some(found) = brought.tick.and_then(|tick| self.plant.shown(tick))
            && is_it(&found)
        {
            return self.answers.has(brought, sent_ns).then_some(found);
        }
        let ticks = self.answers.known(sent_ns);
        let mut shown = ticks.filter_map(|tick| self.plant.shown(tick));
        if let Some(found) = shown.find(is_it) {
            return Some(found);
        }
        // Before the first answer it has what the plant showed before the start.
        let first_ns = self.answers.first_ns();
        let before = self.plant.shown.iter().rev().copied();
        let mut before = before
            .chain([self.plant.at_rest])
            .filter(|_| sent_ns <= first_ns);
        before.find(is_it)
    }
}

/// The ticks that answers brought, in order of their coming.
struct Answers {
    /// When an answer came, its tick, and the newest tick by then.
    came: Vec<(u64, u64)>,
}

impl Answers {
    fn of(both: &Both<'_>) -> Answers {
        let answered = both
            .messages
            .iter()
            .filter_map(|row| Some((row.t_receive_ns?, row.tick?)));
        let mut came: Vec<(u64, u64)> = answered.collect();
        came.sort_unstable();
        if both.cell.settings.late == Late::Drop {
            // An answer that was overtaken changes nothing.
            let mut newest = 0;
            came.retain(|(_, tick)| {
                newest = newest.max(*tick);
                *tick == newest
            });
        }
        Answers { came }
    }

    /// The ticks whose answers had come by then, the newest first.
    fn known(&self, t_ns: u64) -> impl Iterator<Item = u64> {
        let until_ns = t_ns.saturating_add(READ_NS);
        let came = self.came.partition_point(|(at_ns, _)| *at_ns <= until_ns);
        self.came[..came].iter().rev().map(|(_, tick)| *tick)
    }

    /// Whether the answer to a message had come by then.
    fn has(&self, brought: &MessageRow, t_ns: u64) -> bool {
        let until_ns = t_ns.saturating_add(READ_NS);
        brought.t_receive_ns.is_some_and(|at_ns| at_ns <= until_ns)
    }

    /// Until when there may have been none.
    fn first_ns(&self) -> u64 {
        self.came
            .first()
            .map_or(u64::MAX, |(at_ns, _)| at_ns.saturating_add(READ_NS))
    }
}

/// Which command the plant held after each that arrived.
#[derive(Default)]
struct HeldCommands(BTreeMap<(u64, u64), u64>);

impl HeldCommands {
    fn of(arrivals: &[ArrivalRow]) -> HeldCommands {
        let mut newest = None;
        let mut held = BTreeMap::new();
        for row in arrivals {
            if row.outcome == ArrivalOutcome::Applied {
                newest = Some(row.seq);
            }
            if let Some(newest) = newest {
                held.insert((row.seq, row.t_arrive_ns), newest);
            }
        }
        HeldCommands(held)
    }

    /// The command that was held after this one had arrived at a time; `None` if none was.
    fn after(&self, seq: u64, t_arrive_ns: u64) -> Option<u64> {
        self.0.get(&(seq, t_arrive_ns)).copied()
    }
}
