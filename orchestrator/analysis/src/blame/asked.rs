//! The messages of a run from its rows, and its link, asked about each of them.

use endpoint::{MessageOutcome, MessageRow};
use link::{Timeline, Way};

use super::message::{Deadline, Message};
use super::{Cause, Facts, Stamps};
use crate::numbered::Numbered;

/// The link is asked this long before and after a run, ns; stamps beyond are no times of the run.
const BEYOND_NS: u64 = 60_000_000_000;
/// A packet enters the link a little after the stamp of its sending: it is asked then, too, ns.
const LOOKS_NS: [u64; 3] = [0, 100_000, 300_000];
/// The link explains an arrival that it would have had at most this much earlier, ns, or a tenth.
const SLACK_NS: u64 = 1_000_000;

/// The messages that were sent, without the link's shares, and the deadlines at which nothing was.
pub(super) fn sent(
    rows: &[MessageRow],
    arrived: &Numbered<(u64, bool)>,
    link: &mut Asked<'_>,
) -> (Vec<Message>, Vec<Deadline>) {
    let (mut messages, mut missed) = (Vec::new(), Vec::new());
    let mut guesses = link.link.clone();
    let mut by_arrival: Vec<&MessageRow> = rows.iter().collect();
    let arrival = |row: &MessageRow| {
        let seen = arrived.get(row.seq);
        (
            row.t_arrive_ns.or_else(|| seen.map(|(t_ns, _)| *t_ns)),
            seen.is_none_or(|(_, is_taken)| *is_taken),
        )
    };
    by_arrival.sort_by_cached_key(|row| (arrival(row).0, row.seq));
    let mut last_ns = None;
    for row in by_arrival {
        let (arrive_ns, is_taken) = arrival(row);
        let send_ns = match (row.outcome, row.t_send_ns, arrive_ns) {
            (MessageOutcome::Missed, ..) | (_, None, None) => {
                missed.push(Deadline {
                    due_ns: row.t_due_ns,
                    message: None,
                });
                continue;
            }
            (_, Some(send_ns), _) => send_ns,
            (_, None, Some(arrive_ns)) => link.guess(&mut guesses, last_ns, arrive_ns),
        };
        last_ns = Some(send_ns);
        messages.push(Message {
            seq: row.seq,
            due_ns: row.t_due_ns,
            send_ns,
            is_guessed: row.t_send_ns.is_none(),
            arrive_ns,
            is_taken,
            receive_ns: row.t_receive_ns,
            tick: row.tick,
            up_ns: 0,
            down_ns: 0,
            up_late: Cause::Ends,
            down_late: Cause::Ends,
        });
    }
    (messages, missed)
}

/// A link that is asked only about the time of its run.
pub(super) struct Asked<'a> {
    pub(super) link: Option<Timeline>,
    pub(super) facts: &'a Facts,
}

impl Asked<'_> {
    /// What a packet meets, ns, and whether it is lost. Must be asked nearly in order of time on each way.
    pub(super) fn ask(&self, link: &mut Option<Timeline>, way: Way, t_ns: u64) -> (u64, bool) {
        let from_ns = self.facts.start_ns.saturating_sub(BEYOND_NS);
        let to_ns = self.facts.end_ns.saturating_add(BEYOND_NS);
        let Some(link) = link.as_mut().filter(|_| (from_ns..to_ns).contains(&t_ns)) else {
            return (0, false);
        };
        let bytes = self.facts.bytes[way as usize];
        let [first, others @ ..] =
            LOOKS_NS.map(|look_ns| link.passage(way, t_ns.saturating_add(look_ns), bytes));
        let is_lost = first.lost || others.iter().any(|one| one.lost);
        (first.delay_ns, is_lost)
    }

    /// Fills in the link's shares of both ways, and says which ways lost a packet.
    pub(super) fn shares(&mut self, messages: &mut [Message], stamps: Stamps) -> Vec<[bool; 2]> {
        let (mut up, mut down) = (self.link.clone(), self.link.clone());
        let mut lost = vec![[false; 2]; messages.len()];
        for (one, lost) in messages.iter_mut().zip(&mut lost) {
            let (delay_ns, is_lost) = self.ask(&mut up, Way::Up, one.send_ns);
            let way_ns = one.arrive_ns.map(|t_ns| t_ns.saturating_sub(one.send_ns));
            one.up_ns = delay_ns.min(way_ns.unwrap_or(0));
            lost[0] = is_lost;
        }
        let mut by_arrival: Vec<usize> = (0..messages.len()).collect();
        by_arrival.sort_by_cached_key(|at| messages[*at].arrive_ns);
        for at in by_arrival {
            let one = &mut messages[at];
            let Some(arrive_ns) = one.arrive_ns else {
                continue;
            };
            let (delay_ns, is_lost) = self.ask(&mut down, Way::Down, arrive_ns);
            let is_unknown = stamps != Stamps::All && one.receive_ns.is_none();
            if is_unknown && one.tick.is_some() && !is_lost {
                one.receive_ns = Some(arrive_ns.saturating_add(delay_ns));
            }
            let way_ns = one.receive_ns.map(|t_ns| t_ns.saturating_sub(arrive_ns));
            one.down_ns = delay_ns.min(way_ns.unwrap_or(u64::MAX));
            lost[at][1] = is_lost;
        }
        lost
    }

    /// When a message was sent that says nothing of it: at the deadline after the last, if the link explains
    /// the rest, or else as late as the link allows.
    fn guess(&self, link: &mut Option<Timeline>, last_ns: Option<u64>, arrive_ns: u64) -> u64 {
        let Facts { start_ns, h_ns, .. } = *self.facts;
        let next_ns = last_ns.map_or(start_ns, |last_ns| {
            let after_ns = last_ns.saturating_add(h_ns / 2).saturating_sub(start_ns);
            start_ns.saturating_add(after_ns.div_ceil(h_ns.max(1)).saturating_mul(h_ns))
        });
        let (due_ns, _) = self.ask(link, Way::Up, next_ns.min(arrive_ns));
        let slack_ns = SLACK_NS + due_ns / 10;
        if next_ns <= arrive_ns && next_ns.saturating_add(due_ns + slack_ns) >= arrive_ns {
            return next_ns;
        }
        let (late_ns, _) = self.ask(link, Way::Up, arrive_ns);
        arrive_ns.saturating_sub(late_ns)
    }
}
