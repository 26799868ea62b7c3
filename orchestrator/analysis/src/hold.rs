//! Where in a run the loop was hurt: the time in which the plant held one command while the error was
//! large, and what kept the next one away.
//!
//! A loop over a network fails in moments. In each, the plant holds its last command, since no other
//! comes: messages are under way, lost, or were never sent.

use std::fmt;
use std::ops::Range;

use endpoint::TickRow;
use link::{Timeline, Way};
use plan::{Plan, file_name};

use crate::budget::{Budget, timeline};
use crate::campaign::Run;
use crate::rows::{ReadError, read};

/// A command that is held for fewer ticks than this is nothing that stands out.
const TICKS_MIN: u64 = 5;

/// How often the link is asked in a hold, ns.
const LOOK_NS: u64 = 1_000_000;

/// A hold of one command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// When it began, s from the controller's first deadline.
    pub at_s: f64,
    /// How long it was, ms.
    pub length_ms: f64,
    /// Messages due in it.
    pub due: u64,
    /// Those that the controller did not send in it: deadlines that it missed, or a schedule that it is behind.
    pub unsent: u64,
    /// Those that never arrived.
    pub lost: u64,
    /// How long the controller waited for the answer that came last in it, ms.
    pub answer_ms: f64,
    /// The longest delay that the link had in it, of both ways, ms.
    pub link_ms: f64,
    /// How late the plant's ticks were in it, at most, ms.
    pub tick_late_ms: f64,
    /// What kept the next command away.
    pub cause: Cause,
}

/// What kept commands away from the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The link's delay.
    Link,
    /// Messages were lost.
    Loss,
    /// The controller waited for an answer, which the link's delay does not explain.
    Answer,
    /// The controller sent nothing.
    Client,
    /// The plant itself ticked late.
    Plant,
    /// None of these explains it.
    Unknown,
}

/// The hold that hurt a run's loop most: the one with the greatest error in it and for as long after it.
/// `None` if no command was held for [five ticks](TICKS_MIN) or more.
///
/// # Errors
/// [`ReadError`] if rows cannot be read.
pub fn worst(run: &Run, plan: &Plan, budget: &Budget) -> Result<Option<Hold>, ReadError> {
    let mut ticks: Vec<TickRow> = Vec::new();
    read(
        &run.folder.join(file_name::TICKS),
        TickRow::COLUMNS,
        |row| {
            ticks.push(*row);
        },
    )?;
    let h_ns = run.cell.settings.h.ns();
    let Some(held) = longest(&ticks, run.cell.settings.r) else {
        return Ok(None);
    };
    let (first, last) = (ticks[held.start], ticks[held.end]);
    let time_ns = first.t_tick_ns..last.t_tick_ns;
    let within = |t_ns: &&u64| time_ns.contains(t_ns);
    let length_ns = time_ns.end.saturating_sub(time_ns.start);
    let late_ns = ticks[held.clone()]
        .iter()
        .map(|row| row.t_tick_ns.saturating_sub(row.t_due_ns))
        .max()
        .unwrap_or(0);
    let lost = budget.lost_ns.iter().filter(within).count() as u64;
    let link_ns = timeline(run, plan).map_or(0, |link| most_delay_ns(link, &time_ns));
    // The part of the hold in which a message was under way; the longest of all.
    let (waited_ns, answer_ns) = budget
        .trips
        .iter()
        .filter_map(|trip| {
            let round_trip_ns = u64::try_from(trip.round_trip_ns()?).ok()?;
            let back_ns = trip.t_send_ns.saturating_add(round_trip_ns);
            let from_ns = trip.t_send_ns.max(time_ns.start);
            Some((
                back_ns.min(time_ns.end).saturating_sub(from_ns),
                round_trip_ns,
            ))
        })
        .max()
        .unwrap_or((0, 0));
    let due = length_ns / h_ns;
    let sent = budget.trips.iter().map(|trip| &trip.t_send_ns);
    let unsent = due.saturating_sub(sent.filter(within).count() as u64 + lost);
    let cause = if late_ns >= length_ns / 2 {
        Cause::Plant
    } else if 2 * lost >= due.max(1) {
        Cause::Loss
    } else if link_ns >= length_ns / 2 {
        Cause::Link
    } else if 2 * unsent >= due.max(1) && waited_ns >= length_ns / 2 {
        Cause::Answer
    } else if 2 * unsent >= due.max(1) {
        Cause::Client
    } else {
        Cause::Unknown
    };
    let ms = |ns: u64| ns as f64 / 1e6;
    Ok(Some(Hold {
        at_s: budget.second(time_ns.start),
        length_ms: ms(length_ns),
        due,
        unsent,
        lost,
        answer_ms: ms(answer_ns),
        link_ms: ms(link_ns),
        tick_late_ms: ms(late_ns),
        cause,
    }))
}

/// The ticks of the hold that hurt most, from the one that took the command to the one that took the
/// next. The response ends with the last command: what is held after it is no matter.
fn longest(ticks: &[TickRow], r: f64) -> Option<Range<usize>> {
    let mut holds: Vec<Range<usize>> = Vec::new();
    let mut since: Option<(u64, usize)> = None;
    for (at, row) in ticks.iter().enumerate() {
        let Some(seq) = row.seq else { continue };
        match since {
            Some((held, from)) if held != seq => {
                holds.push(from..at);
                since = Some((seq, at));
            }
            Some(_) => {}
            None => since = Some((seq, at)),
        }
    }
    holds.retain(|hold| hold.len() as u64 >= TICKS_MIN);
    let error = |hold: &Range<usize>| {
        let end = (hold.end + hold.len()).min(ticks.len());
        let of = ticks[hold.start..end].iter();
        of.map(|row| (row.y - r).abs()).sum::<f64>()
    };
    holds
        .into_iter()
        .max_by(|one, other| error(one).total_cmp(&error(other)))
}

/// The longest delay of either way that a packet meets in a time, ns.
fn most_delay_ns(mut link: Timeline, time_ns: &Range<u64>) -> u64 {
    let mut most = 0;
    let mut t_ns = time_ns.start;
    while t_ns < time_ns.end {
        for way in [Way::Up, Way::Down] {
            most = most.max(link.state_at(way, t_ns).delay_ns);
        }
        t_ns = t_ns.saturating_add(LOOK_NS);
    }
    most
}

impl fmt::Display for Hold {
    /// `at 3.21 s the plant held one command for 412 ms: the link delayed messages by up to 398 ms (137 were
    /// due in that time)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Hold {
            at_s,
            length_ms,
            due,
            unsent,
            lost,
            answer_ms,
            link_ms,
            tick_late_ms,
            cause,
        } = self;
        write!(
            f,
            "at {at_s:.2} s the plant held one command for {length_ms:.0} ms: "
        )?;
        match cause {
            Cause::Link => write!(f, "the link delayed messages by up to {link_ms:.0} ms"),
            Cause::Loss => write!(f, "{lost} messages were lost"),
            Cause::Answer => write!(
                f,
                "the controller waited {answer_ms:.0} ms for an answer, of which the link's delay explains \
                 {link_ms:.0} ms each way at most; a lost packet was sent again, or an end was held up"
            ),
            Cause::Client => write!(
                f,
                "the controller left out or was late with {unsent} messages"
            ),
            Cause::Plant => write!(f, "its own ticks were up to {tick_late_ms:.0} ms late"),
            Cause::Unknown => write!(f, "neither the link nor lost messages explain it"),
        }?;
        let also: Vec<String> = [
            (*cause != Cause::Client && *unsent > 0).then(|| format!("{unsent} not sent")),
            (*cause != Cause::Loss && *lost > 0).then(|| format!("{lost} lost")),
        ]
        .into_iter()
        .flatten()
        .collect();
        let also = if also.is_empty() {
            String::new()
        } else {
            format!(", {}", also.join(", "))
        };
        write!(f, " ({due} due in that time{also})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(seqs: &[(u64, f64)]) -> Vec<TickRow> {
        let row = |(k, (seq, y)): (u64, &(u64, f64))| TickRow {
            k,
            t_due_ns: k,
            t_tick_ns: k,
            u: 0.0,
            y: *y,
            seq: Some(*seq),
            u_applied: None,
        };
        (0..).zip(seqs).map(row).collect()
    }

    #[test]
    fn the_hold_with_the_greater_error_hurts_more_than_the_longer_one() {
        let long = (0..20).map(|_| (1, 1.0));
        let short = (0..6).map(|_| (2, 3.0));
        let end = [(3, 1.0), (4, 1.0)];
        let all: Vec<(u64, f64)> = long.chain(short).chain(end).collect();
        assert_eq!(longest(&rows(&all), 1.0), Some(20..26));
        // The last command is held until the run ends: that is no hold.
        let all: Vec<(u64, f64)> = (0..9).map(|_| (1, 0.0)).collect();
        assert_eq!(longest(&rows(&all), 1.0), None);
    }

    #[test]
    fn a_hold_reads_as_a_sentence() {
        let hold = Hold {
            at_s: 3.207,
            length_ms: 412.4,
            due: 137,
            unsent: 2,
            lost: 0,
            answer_ms: 401.0,
            link_ms: 398.0,
            tick_late_ms: 0.1,
            cause: Cause::Link,
        };
        insta::assert_snapshot!(hold.to_string(), @"at 3.21 s the plant held one command for 412 ms: the link delayed messages by up to 398 ms (137 due in that time, 2 not sent)");
    }
}
