//! Compares every message of the loop with the link, each way: it must not be quicker than the link,
//! nor later than client, kernel and loss explain, and the plant must have answered it at the far side.
//!
//! The client and the plant stamp each message. Its first packet enters the link a little after the
//! stamp, so the state of the link in that window counts. If a connection is opened for a message, it
//! crosses the link three times. What is lost is resent, after 200 ms at the earliest.

use std::collections::VecDeque;

use endpoint::{ArrivalRow, MessageOutcome, MessageRow};
use link::Way;
use plan::evidence::Messages;

use crate::connecting::Opened;
use crate::crossed::judge;
use crate::crossing::{Crossing, cross};
use crate::fault::LinkFault;
use crate::limit::{QUICKER_MS, QUICKER_PER_MILLE};
use crate::milliseconds::{ms, ns};
use crate::terms::{MESSAGE_BYTES, Swamped, Terms};

/// A connection is free again this long after its answer arrived.
const FREED_NS: u64 = 1_000_000;

/// A connection that has been idle for this long may have been closed: webloop's own clients close it
/// after 4 s.
const IDLE_NS: u64 = 3_500_000_000;

/// Compares the messages of a run with its link.
#[must_use]
pub fn hold(messages: &[MessageRow], arrivals: &[ArrivalRow], terms: &Terms) -> Messages {
    let is_inside = |row: &&MessageRow| {
        let stamps = [row.t_send_ns, row.t_arrive_ns, row.t_receive_ns];
        let mut stamps = stamps.into_iter().flatten();
        stamps.all(|t_ns| terms.run_ns.contains(&t_ns))
    };
    let all = messages.iter().filter(|row| row.t_send_ns.is_some());
    let (mut sent, outside): (Vec<&MessageRow>, Vec<&MessageRow>) = all.partition(is_inside);
    sent.sort_by_key(|row| row.seq);
    let recorded = Recorded::of(arrivals, terms);
    let is_unborne = |row: &&&MessageRow| recorded.is_unborne(row, terms);
    let unborne = sent.iter().filter(is_unborne).count() as u64;
    let openings = openings(&sent, terms);
    let up = sent.iter().zip(&openings).filter_map(|(row, opening)| {
        Some(Crossing {
            enters_ns: row.t_send_ns?,
            leaves_ns: recorded.arrive_ns(row),
            opened: opening.opened,
            given_up_ns: None,
            is_unsure: opening.is_unsure,
        })
    });
    let up: Vec<Crossing> = up.collect();
    // What became of its answer is not known of a message that only `Arrived`.
    let is_known = |(row, _): &(&&MessageRow, &Opening)| row.outcome != MessageOutcome::Arrived;
    let mut down: Vec<Crossing> = sent
        .iter()
        .zip(&openings)
        .filter(is_known)
        .filter_map(|(row, opening)| {
            Some(Crossing {
                enters_ns: recorded.arrive_ns(row)?,
                leaves_ns: row.t_receive_ns,
                opened: Opened::No,
                given_up_ns: row
                    .t_send_ns
                    .map(|t_ns| t_ns.saturating_add(ns(terms.timeout_ms))),
                is_unsure: opening.is_unsure,
            })
        })
        .collect();
    down.sort_by_key(|crossing| crossing.enters_ns);
    let swamped = Swamped::of(terms);
    let arrived = || {
        messages
            .iter()
            .filter(|row| row.outcome == MessageOutcome::Arrived)
    };
    Messages {
        up: cross(Way::Up, &up, terms, &swamped),
        down: cross(Way::Down, &down, terms, &swamped),
        back_sooner: back_sooner(&sent, terms),
        outside: outside.len() as u64,
        unborne,
        unstamped: arrived().filter(|row| row.t_send_ns.is_none()).count() as u64,
        unreceipted: arrived().count() as u64,
    }
}

/// The arrivals that the plant recorded during a run: each message's number and when it arrived, in order. A message
/// whose connection broke may be sent again, and arrive twice.
struct Recorded(Vec<(u64, u64)>);

impl Recorded {
    fn of(arrivals: &[ArrivalRow], terms: &Terms) -> Recorded {
        let is_inside = |row: &&ArrivalRow| terms.run_ns.contains(&row.t_arrive_ns);
        let inside = arrivals.iter().filter(is_inside);
        let mut all: Vec<(u64, u64)> = inside.map(|row| (row.seq, row.t_arrive_ns)).collect();
        all.sort_unstable();
        Recorded(all)
    }

    /// How many arrivals come before this one, by number and time.
    fn place(&self, arrival: (u64, u64)) -> usize {
        let all = &self.0;
        // Numbers follow each other, so nearly every message is where its number says.
        let first = all.first().map_or(0, |(seq, _)| *seq);
        let likely = arrival.0.saturating_sub(first) as usize;
        let is_before = |at: usize| all.get(at).is_some_and(|one| *one < arrival);
        let is_it =
            likely < all.len() && !is_before(likely) && likely.checked_sub(1).is_none_or(is_before);
        match is_it {
            true => likely,
            false => all.partition_point(|one| *one < arrival),
        }
    }

    /// When a message arrived first from `from_ns` on.
    fn after_ns(&self, seq: u64, from_ns: u64) -> Option<u64> {
        let at = self.place((seq, from_ns));
        let next = self.0.get(at).filter(|(other, _)| *other == seq);
        next.map(|(_, t_ns)| *t_ns)
    }

    /// When a message arrived, by its own row or else by the plant's.
    fn arrive_ns(&self, row: &MessageRow) -> Option<u64> {
        row.t_arrive_ns.or_else(|| self.after_ns(row.seq, 0))
    }

    /// Whether a message's answer names an arrival that is not recorded, and was not lost with the plant.
    fn is_unborne(&self, row: &MessageRow, terms: &Terms) -> bool {
        // One that only arrived is the plant's own row, whatever number it has.
        let own_ns = row
            .t_arrive_ns
            .filter(|_| row.outcome != MessageOutcome::Arrived);
        own_ns.is_some_and(|own_ns| {
            let near_ns = self.after_ns(row.seq, own_ns.saturating_sub(1_000));
            let is_recorded = near_ns.is_some_and(|t_ns| t_ns <= own_ns.saturating_add(1_000));
            !is_recorded && !terms.hits.loses_row(own_ns)
        })
    }
}

/// What is known of a message's connection.
struct Opening {
    /// Whether it was opened for the message.
    opened: Opened,
    /// Whether a fault of the link may have broken it, before the message or under it, or one of an end have held
    /// the message up.
    is_unsure: bool,
}

/// For each message, whether a connection may have been opened for it, since none was free that had
/// been used recently, and whether a fault may have broken that connection. Clients take the connection that was used last; one that becomes free goes first
/// to a message that waits for one.
fn openings(sent: &[&MessageRow], terms: &Terms) -> Vec<Opening> {
    let mut link = terms.timeline.clone();
    let mut ends: Vec<u64> = sent.iter().filter_map(|row| row.t_receive_ns).collect();
    ends.sort_unstable();
    let mut ends = ends.into_iter().map(|t_ns| t_ns + FREED_NS).peekable();
    // When each free connection became free; the one used last is at the end. One is opened in advance.
    let mut free = vec![u64::MAX];
    // For each message that found none, the latest time until which it waits: its own is open by then.
    let mut waiting: VecDeque<u64> = VecDeque::new();
    let is_opened = |row: &&MessageRow| {
        let send_ns = row.t_send_ns.unwrap_or_default();
        while let Some(freed_ns) = ends.next_if(|freed_ns| *freed_ns <= send_ns) {
            while waiting
                .front()
                .is_some_and(|until_ns| *until_ns <= freed_ns)
            {
                waiting.pop_front();
            }
            if waiting.pop_front().is_none() {
                free.push(freed_ns);
            }
        }
        let broken_ns = link.broken_ns(send_ns).max(terms.hits.broken_ns(send_ns));
        if let Some(broken_ns) = broken_ns {
            // Open since before the break, so it may be gone, and its client not know it.
            free.retain(|since_ns| *since_ns > broken_ns && *since_ns < u64::MAX);
        }
        let found = free.pop();
        let is_free = found.is_some_and(|since_ns| send_ns.saturating_sub(since_ns) < IDLE_NS);
        if !is_free {
            // Those below it have been idle for longer.
            free.clear();
            let delay_ns = link.passage(Way::Up, send_ns, MESSAGE_BYTES).delay_ns;
            waiting.push_back(
                row.t_arrive_ns
                    .map_or(u64::MAX, |t_ns| t_ns - delay_ns.min(t_ns)),
            );
        }
        let until_ns = row.t_receive_ns.unwrap_or(send_ns.saturating_add(IDLE_NS));
        let breaks_under_way = link.broken_ns(until_ns) >= Some(send_ns);
        let broke_before = broken_ns.is_some_and(|t_ns| send_ns - t_ns.min(send_ns) < IDLE_NS);
        Opening {
            opened: terms.connecting.opened(is_free),
            is_unsure: breaks_under_way
                || (!is_free && broke_before)
                || terms.hits.meets(send_ns, until_ns),
        }
    };
    sent.iter().map(is_opened).collect()
}

/// Number of messages that were back sooner than the link allows. One clock has both stamps, but the link's
/// state changes, so how far that clock may be off counts here too.
fn back_sooner(sent: &[&MessageRow], terms: &Terms) -> u64 {
    let mut link = terms.timeline.clone();
    let within_ns = ns(terms.allowance.enters_within_ms);
    let is_sooner = |row: &&&MessageRow| {
        let (Some(send_ns), Some(receive_ns)) = (row.t_send_ns, row.t_receive_ns) else {
            return false;
        };
        let mut is_sooner = |held_ns| {
            let up_ns = terms.earliest_ns(&mut link, Way::Up, send_ns, held_ns);
            let wait_ns = within_ns.max(receive_ns.saturating_sub(up_ns));
            let down_ns = terms.earliest_ns(&mut link, Way::Down, up_ns, wait_ns);
            let sooner_ms = ms(down_ns) - ms(receive_ns);
            sooner_ms > QUICKER_MS + terms.allowance.clock_ms
        };
        // Held for longer than is usual between its stamp and its sending, it met a later state of the link.
        is_sooner(within_ns) && is_sooner(receive_ns.saturating_sub(send_ns).max(within_ns))
    };
    sent.iter().filter(is_sooner).count() as u64
}

/// The evidence against the link; empty if it was the one asked for.
#[must_use]
pub fn faults(messages: &Messages, terms: &Terms) -> Vec<LinkFault> {
    let mut faults = Vec::new();
    for (way, crossed) in [(Way::Up, &messages.up), (Way::Down, &messages.down)] {
        judge(crossed, way, terms, &mut faults);
    }
    let answered = messages.down.count;
    let sooner = QUICKER_PER_MILLE * answered / 1_000;
    if messages.back_sooner > sooner {
        faults.push(LinkFault {
            words: format!(
                "{} of {answered} messages came back quicker than the link allows: they went \
                 around it (limit {sooner})",
                messages.back_sooner
            ),
            by_lateness: false,
            is_busy: false,
        });
    }
    if messages.outside > 0 {
        faults.push(LinkFault {
            words: format!(
                "{} messages have stamps outside the time of the run: their client uses \
                 another clock",
                messages.outside
            ),
            by_lateness: false,
            is_busy: false,
        });
    }
    if messages.unborne > 0 {
        faults.push(LinkFault {
            words: format!(
                "{} answers name an arrival that the plant did not record: they are not from \
                 this plant",
                messages.unborne
            ),
            by_lateness: false,
            is_busy: false,
        });
    }
    faults
}
