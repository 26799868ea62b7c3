//! The messages of a run as blame sees them: each with the link's share of both ways, and with what made it
//! later than that.

use endpoint::{Carriage, Connection, MessageOutcome, MessageRow, Outstanding};
use link::{Timeline, Way};

use super::asked::{Asked, sent};
use super::message::{Deadline, Message};
use super::{Cause, Facts, Stamps};
use crate::numbered::Numbered;
use crate::statistics::upper_median;

/// What a way takes beyond the link is asked about from here on, ns: less is what kernels always take.
const LATE_NS: u64 = 500_000;
/// Messages that come within this of each other came together, ns.
const TOGETHER_NS: u64 = 1_000_000;
/// A handshake explains a delay that differs from it by less than this, ns, or a quarter.
const HANDSHAKE_NS: u64 = 1_000_000;
/// A packet that was lost is sent again after this at the earliest, ns; Linux waits 200 ms.
const AGAIN_NS: u64 = 150_000_000;
/// A link stalls that takes this much more than four times what is usual, ns.
const STALL_NS: u64 = 50_000_000;

/// All messages, in the order of sending, and all deadlines, in their own.
#[derive(Debug)]
pub(super) struct Traffic {
    pub(super) messages: Vec<Message>,
    pub(super) deadlines: Vec<Deadline>,
    pub(super) stamps: Stamps,
    /// The median round trip, ns.
    pub(super) round_trip_ns: u64,
}

impl Traffic {
    pub(super) fn of(
        rows: &[MessageRow],
        arrived: &Numbered<(u64, bool)>,
        link: Option<Timeline>,
        facts: &Facts,
    ) -> Traffic {
        let mut link = Asked { link, facts };
        let (mut messages, missed) = sent(rows, arrived, &mut link);
        messages.sort_by_cached_key(|one| (one.send_ns, one.seq));
        let stamps = if messages.iter().any(|one| one.is_guessed) {
            Stamps::None
        } else if rows
            .iter()
            .any(|row| row.outcome == MessageOutcome::Arrived)
        {
            Stamps::Sent
        } else {
            Stamps::All
        };
        let lost = link.shares(&mut messages, stamps);
        let mut deadlines: Vec<Deadline> = missed;
        deadlines.extend(messages.iter().enumerate().map(|(at, one)| Deadline {
            due_ns: if one.is_guessed {
                one.send_ns
            } else {
                one.due_ns
            },
            message: Some(at),
        }));
        deadlines.sort_by_key(|one| one.due_ns);
        let trips = messages
            .iter()
            .filter_map(|one| one.receive_ns?.checked_sub(one.send_ns));
        let mut trips: Vec<u64> = trips.collect();
        let round_trip_ns = upper_median(&mut trips, Ord::cmp).unwrap_or(0);
        let mut traffic = Traffic {
            messages,
            deadlines,
            stamps,
            round_trip_ns,
        };
        traffic.explain(&lost, &mut link, facts);
        traffic
    }

    /// Fills in what made each message later than the link.
    fn explain(&mut self, lost: &[[bool; 2]], link: &mut Asked<'_>, facts: &Facts) {
        let opened = self.opened(lost, link, facts);
        for at in 0..self.messages.len() {
            let one = self.messages[at];
            if one.up_late_ns() < LATE_NS {
                continue;
            }
            let before = at.checked_sub(1).map(|before| self.messages[before]);
            let behind = before.filter(|before| {
                let arrive_ns = before.arrive_ns.unwrap_or(0);
                let is_together = one
                    .arrive_ns
                    .is_some_and(|t_ns| t_ns.abs_diff(arrive_ns) <= TOGETHER_NS);
                before.up_late_ns() >= LATE_NS
                    && arrive_ns > one.send_ns
                    && (is_together || before.up_late == Cause::Connection)
            });
            self.messages[at].up_late = match (lost[at][0], opened[at], behind) {
                (true, ..) => Cause::Loss,
                (_, Some(cause), _) => cause,
                (_, _, Some(before)) => before.up_late,
                _ if self.stood_still(one.send_ns, one.arrive_ns.unwrap_or(0), facts) => {
                    Cause::Controller
                }
                _ => Cause::Ends,
            };
        }
        let mut by_arrival: Vec<usize> = (0..self.messages.len()).collect();
        by_arrival.sort_by_cached_key(|at| self.messages[*at].arrive_ns);
        let mut before: Option<Message> = None;
        for at in by_arrival {
            let one = self.messages[at];
            if one.down_late_ns() >= LATE_NS {
                let from_ns = one
                    .arrive_ns
                    .unwrap_or(one.send_ns)
                    .saturating_add(one.down_ns);
                let behind = before.filter(|before| {
                    before.down_late_ns() >= LATE_NS
                        && before.receive_ns.is_some_and(|t_ns| t_ns > from_ns)
                        && one.receive_ns.zip(before.receive_ns).is_some_and(
                            |(one_ns, before_ns)| one_ns.abs_diff(before_ns) <= TOGETHER_NS,
                        )
                });
                let until_ns = one.receive_ns.unwrap_or(from_ns);
                self.messages[at].down_late = match (lost[at][1], behind) {
                    (true, _) => Cause::Loss,
                    (_, Some(before)) => before.down_late,
                    // Who sends in time meanwhile is awake.
                    _ if self.sent_in_time(from_ns, until_ns, facts) => Cause::Ends,
                    _ => Cause::Controller,
                };
            }
            before = Some(self.messages[at]);
        }
    }

    /// Of each message whether a connection was opened for it: the cause of its delay then.
    fn opened(
        &self,
        lost: &[[bool; 2]],
        link: &mut Asked<'_>,
        facts: &Facts,
    ) -> Vec<Option<Cause>> {
        let (mut back, mut again) = (link.link.clone(), link.link.clone());
        let mut ends: Vec<u64> = self
            .messages
            .iter()
            .map(|one| one.over_ns(facts.timeout_ns))
            .collect();
        ends.sort_unstable();
        let (mut over, mut most) = (0, 0);
        let mut opened = Vec::with_capacity(self.messages.len());
        let usual_ns = self.link_ns();
        for (at, one) in self.messages.iter().enumerate() {
            while ends.get(over).is_some_and(|end_ns| *end_ns <= one.send_ns) {
                over += 1;
            }
            let under_way = (at + 1).saturating_sub(over);
            let is_more = under_way > most && most > 0;
            most = most.max(under_way);
            let late_ns = one.up_late_ns();
            if late_ns < LATE_NS || facts.transport.carriage() != Carriage::Requests {
                opened.push(None);
                continue;
            }
            let there_ns = one.send_ns.saturating_add(one.up_ns);
            let (down_ns, is_lost_down) = link.ask(&mut back, Way::Down, there_ns);
            let here_ns = there_ns.saturating_add(down_ns);
            let (up_ns, is_lost_up) = link.ask(&mut again, Way::Up, here_ns);
            let shake_ns = down_ns.saturating_add(up_ns);
            let is_like = shake_ns >= 2 * HANDSHAKE_NS
                && late_ns.abs_diff(shake_ns) <= HANDSHAKE_NS.max(shake_ns / 4);
            let is_new = is_more || facts.connection == Connection::New;
            // Who needs one more waits for it, or for one that is free before.
            let is_opened = is_like || is_new;
            let is_lost = is_lost_down || is_lost_up || lost[at][0];
            let is_sent_again = is_lost && late_ns > shake_ns.saturating_add(AGAIN_NS);
            opened.push(if is_sent_again {
                Some(Cause::Loss)
            } else if is_opened && shake_ns > usual_ns.saturating_mul(4).saturating_add(STALL_NS) {
                // A handshake takes so long only while the link stalls.
                Some(Cause::Link)
            } else {
                is_opened.then_some(Cause::Connection)
            });
        }
        opened
    }

    /// The median of what the link takes there and back, ns.
    fn link_ns(&self) -> u64 {
        let ways = self.messages.iter();
        let mut ways: Vec<u64> = ways
            .map(|one| one.up_ns.saturating_add(one.down_ns))
            .collect();
        upper_median(&mut ways, Ord::cmp).unwrap_or(0)
    }

    /// The deadlines from one instant to another.
    pub(super) fn due(&self, from_ns: u64, to_ns: u64) -> &[Deadline] {
        let at = |t_ns: u64| self.deadlines.partition_point(|one| one.due_ns <= t_ns);
        self.deadlines.get(at(from_ns)..at(to_ns)).unwrap_or(&[])
    }

    /// Whether a deadline in this time passed without a message, although one more might have been under way.
    fn stood_still(&self, from_ns: u64, to_ns: u64, facts: &Facts) -> bool {
        let missed = |one: &Deadline| {
            let send_ns = one.message.map(|at| self.messages[at].send_ns);
            send_ns.is_none_or(|send_ns| send_ns >= to_ns)
        };
        facts.outstanding != Outstanding::ONE && self.due(from_ns, to_ns).iter().any(missed)
    }

    /// Whether a message was sent in this time at its deadline.
    fn sent_in_time(&self, from_ns: u64, to_ns: u64, facts: &Facts) -> bool {
        let last_ns = to_ns.saturating_sub(LATE_NS);
        self.due(from_ns, last_ns).iter().any(|one| {
            one.message.is_some_and(|at| {
                let send_ns = self.messages[at].send_ns;
                send_ns < last_ns && send_ns.saturating_sub(one.due_ns) < facts.h_ns / 2
            })
        })
    }
}
