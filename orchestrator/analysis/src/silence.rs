//! Whether a run ended in silence: no command took effect any more, for so long that the plant was on its own,
//! and by whose doing.
//!
//! The ticks say from when on. Whether the controller sent, and whether what it sent arrived, say who. A pause
//! after which commands come again is no silence: what it did to y is in y.

use std::fmt;
use std::ops::Range;

use endpoint::{ArrivalRow, MessageOutcome, MessageRow};
use link::{Timeline, Way};
use serde::{Deserialize, Serialize};

/// The end of a run without commands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Silence {
    /// When the last command took effect, s from the first deadline; 0 if none did.
    pub from_s: f64,
    /// Whose doing it was.
    pub by: Doer,
    /// What the controller sent, where that makes it the link's: was the link open then, it is another's.
    #[serde(skip)]
    pub(crate) sent: Option<Sent>,
}

/// What a controller sent before or in a silence, without an answer that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sent {
    /// One message, for whose answer it waits. The message arrived then, ns, and its answer left.
    One { arrived_ns: u64 },
    /// Messages in this time, none of which arrived.
    More { from_ns: u64, to_ns: u64 },
}

impl Sent {
    /// Who was silent, if this link does not explain it: who did not read what came.
    pub(crate) fn unread_by(self, mut link: Timeline, end_ns: u64) -> Option<Doer> {
        match self {
            Self::One { arrived_ns } => {
                let state = link.state_at(Way::Down, arrived_ns);
                let is_open = !state.lost && arrived_ns.saturating_add(state.delay_ns) < end_ns;
                is_open.then_some(Doer::Controller)
            }
            Self::More { from_ns, to_ns } => (!is_cut(link, from_ns..to_ns)).then_some(Doer::Plant),
        }
    }
}

/// Who kept commands away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Doer {
    /// The controller sent nothing, and waited for no answer.
    Controller,
    /// What the controller sent did not arrive, or it waited for answers that did not come.
    Link,
    /// Commands arrived, and the plant applied none, or it did not tick.
    Plant,
}

impl fmt::Display for Silence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from_s = self.from_s;
        match self.by {
            Doer::Controller => write!(f, "the controller sent nothing after {from_s:.2} s"),
            Doer::Link => write!(f, "the link let nothing through after {from_s:.2} s"),
            Doer::Plant => write!(f, "the plant took no command after {from_s:.2} s"),
        }
    }
}

/// The shortest silence that leaves a plant on its own, ns, in a run of this length: a second, but at most a
/// fifth of the run and at least a tenth; and three sample times.
#[must_use]
pub fn least_ns(duration_ns: u64, h_ns: u64) -> u64 {
    const SECOND_NS: u64 = 1_000_000_000;
    let of_run = SECOND_NS.max(duration_ns / 10).min(duration_ns / 5);
    of_run.max(3 * h_ns)
}

/// Whether a link lets next to nothing through on one of its ways, from a time to another, ns.
#[must_use]
pub fn is_cut(mut link: Timeline, time_ns: Range<u64>) -> bool {
    /// Instants at which it is asked.
    const LOOKS: u64 = 50;
    let length_ns = time_ns.end.saturating_sub(time_ns.start);
    Way::BOTH.into_iter().any(|way| {
        let instant = |look| time_ns.start + length_ns / LOOKS * look;
        let passes = (0..LOOKS).map(instant).filter(|t_ns| {
            let state = link.state_at(way, *t_ns);
            !state.lost && t_ns.saturating_add(state.delay_ns) < time_ns.end
        });
        passes.count() as u64 * 10 < LOOKS
    })
}

/// A silence whose doer is not known yet: takes the other rows of the run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SilenceTrace {
    /// The first deadline, and the last command's effect, ns.
    start_ns: u64,
    from_ns: u64,
    to_ns: u64,
    ticking: Ticking,
    sent: u64,
    arrived: u64,
    /// The newest message that was sent in time.
    newest: Option<Newest>,
    /// The last arrival before the middle of the silence, ns.
    arrived_ns: Option<u64>,
}

/// Whether the plant itself went on while nothing came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ticking {
    /// It ticked.
    On,
    /// It did not.
    Stopped,
}

/// The newest message of a controller.
#[derive(Debug, Clone, Copy)]
struct Newest {
    sent_ns: u64,
    /// Whether the controller still waits for its answer in the middle of the silence.
    waits: bool,
    /// When it arrived, by its answer.
    arrived_ns: Option<u64>,
}

impl SilenceTrace {
    /// From the last command's effect to the planned end.
    pub(crate) fn new(start_ns: u64, from_ns: u64, to_ns: u64, ticking: Ticking) -> Self {
        Self {
            start_ns,
            from_ns,
            to_ns,
            ticking,
            sent: 0,
            arrived: 0,
            newest: None,
            arrived_ns: None,
        }
    }

    /// The middle of the silence: what is under way when it begins says nothing.
    fn half_ns(&self) -> u64 {
        self.from_ns + self.to_ns.saturating_sub(self.from_ns) / 2
    }

    /// The last tenth of the silence: what is sent or arrives in it comes too late to end it.
    fn late_ns(&self) -> u64 {
        self.to_ns - self.to_ns.saturating_sub(self.from_ns) / 10
    }

    pub(crate) fn message(&mut self, row: &MessageRow) {
        let Some(sent_ns) = row.t_send_ns else { return };
        if sent_ns >= self.late_ns() {
            return;
        }
        let half_ns = self.half_ns();
        self.sent += u64::from(sent_ns >= half_ns);
        let is_unread = row.t_receive_ns.is_none_or(|back_ns| back_ns >= half_ns);
        if self.newest.is_none_or(|newest| newest.sent_ns <= sent_ns) {
            self.newest = Some(Newest {
                sent_ns,
                // Of a program that leaves no rows only what arrived is known.
                waits: is_unread && row.outcome != MessageOutcome::Arrived,
                arrived_ns: row.t_arrive_ns,
            });
        }
    }

    pub(crate) fn arrival(&mut self, row: &ArrivalRow) {
        let at_ns = row.t_arrive_ns;
        let half_ns = self.half_ns();
        self.arrived += u64::from((half_ns..self.late_ns()).contains(&at_ns));
        if at_ns < half_ns {
            self.arrived_ns = self.arrived_ns.max(Some(at_ns));
        }
    }

    pub(crate) fn finish(self) -> Silence {
        let newest = self.newest.filter(|newest| newest.waits);
        let by = if self.ticking == Ticking::Stopped || self.arrived > 0 {
            Doer::Plant
        } else if self.sent > 0 || newest.is_some() {
            Doer::Link
        } else {
            Doer::Controller
        };
        // The newest message is the last to arrive, where it arrives at all.
        let one = newest.and_then(|newest| {
            let last = self.arrived_ns.filter(|at_ns| *at_ns >= newest.sent_ns);
            let arrived_ns = newest.arrived_ns.or(last)?;
            Some(Sent::One { arrived_ns })
        });
        let sent = match self.sent {
            0 => one,
            _ => Some(Sent::More {
                from_ns: self.half_ns(),
                to_ns: self.late_ns(),
            }),
        };
        Silence {
            from_s: self.from_ns.saturating_sub(self.start_ns) as f64 / 1e9,
            by,
            sent: sent.filter(|_| by == Doer::Link),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    fn message(sent_s: u64, back_s: Option<u64>, outcome: MessageOutcome) -> MessageRow {
        MessageRow {
            seq: sent_s,
            t_due_ns: sent_s * S,
            t_send_ns: Some(sent_s * S),
            t_receive_ns: back_s.map(|back_s| back_s * S),
            t_arrive_ns: None,
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome,
            y_seq: None,
        }
    }

    fn arrival(at_s: u64) -> ArrivalRow {
        ArrivalRow {
            n: at_s,
            seq: at_s,
            t_send_ns: None,
            t_arrive_ns: at_s * S,
            tick: 0,
            u: 0.0,
            outcome: endpoint::ArrivalOutcome::Stale,
        }
    }

    /// The doer of a silence from 4 s to 12 s.
    fn doer(messages: &[MessageRow], arrivals: &[ArrivalRow], ticking: Ticking) -> Doer {
        let mut trace = SilenceTrace::new(0, 4 * S, 12 * S, ticking);
        messages.iter().for_each(|row| trace.message(row));
        arrivals.iter().for_each(|row| trace.arrival(row));
        let silence = trace.finish();
        assert_eq!(silence.from_s, 4.0);
        silence.by
    }

    #[test]
    fn a_silence_is_of_the_one_after_whom_nothing_came() {
        let answered = [1, 2, 3].map(|s| message(s, Some(s + 1), MessageOutcome::Answered));
        let lost = |s| message(s, None, MessageOutcome::Timeout);
        assert_eq!(
            doer(&answered, &[arrival(3)], Ticking::On),
            Doer::Controller
        );
        // An early loss is no reason for a late silence.
        let early = [&[lost(1)], &answered[1..]].concat();
        assert_eq!(doer(&early, &[arrival(3)], Ticking::On), Doer::Controller);
        // It went on sending; or it waits for its one answer.
        let sending = [&answered[..], &[lost(7), lost(9)]].concat();
        assert_eq!(doer(&sending, &[arrival(3)], Ticking::On), Doer::Link);
        let waiting = [&answered[..], &[lost(4)]].concat();
        assert_eq!(doer(&waiting, &[arrival(3)], Ticking::On), Doer::Link);
        // It came back when it was too late to send.
        let mut thawed = message(11, None, MessageOutcome::Timeout);
        thawed.t_send_ns = Some(12 * S - S / 2);
        let mut late = arrival(11);
        late.t_arrive_ns = 12 * S - S / 4;
        let frozen = [&answered[..], &[thawed]].concat();
        assert_eq!(
            doer(&frozen, &[arrival(3), late], Ticking::On),
            Doer::Controller
        );
        // What arrived was not applied; or the plant itself stood still.
        assert_eq!(doer(&sending, &[arrival(9)], Ticking::On), Doer::Plant);
        assert_eq!(
            doer(&answered, &[arrival(3)], Ticking::Stopped),
            Doer::Plant
        );
        // A program that leaves no rows waits for nothing that is known.
        let own = [message(3, None, MessageOutcome::Arrived)];
        assert_eq!(doer(&own, &[arrival(3)], Ticking::On), Doer::Controller);
    }

    #[test]
    fn a_message_that_waits_has_arrived_or_not() {
        let sent = |message: &MessageRow, arrivals: &[ArrivalRow]| {
            let mut trace = SilenceTrace::new(0, 4 * S, 12 * S, Ticking::On);
            trace.message(message);
            arrivals.iter().for_each(|row| trace.arrival(row));
            trace.finish().sent
        };
        let one = |arrived_ns| Some(Sent::One { arrived_ns });
        let waiting = message(4, None, MessageOutcome::Timeout);
        assert_eq!(sent(&waiting, &[arrival(3)]), None);
        assert_eq!(sent(&waiting, &[arrival(3), arrival(5)]), one(5 * S));
        // Its answer was read at last, and says when the message arrived.
        let mut read = message(4, Some(12), MessageOutcome::Answered);
        read.t_arrive_ns = Some(4 * S + 1);
        assert_eq!(sent(&read, &[]), one(4 * S + 1));
        // One that goes on sending waits for none.
        let going_on = message(9, None, MessageOutcome::Timeout);
        assert_eq!(
            sent(&going_on, &[]),
            Some(Sent::More {
                from_ns: 8 * S,
                to_ns: 11 * S + S / 5
            })
        );
    }

    #[test]
    fn the_shortest_silence_is_a_second_in_the_middle_and_a_part_of_the_run_at_its_ends() {
        let least_s = |duration_s: u64| least_ns(duration_s * S, 10_000_000) as f64 / 1e9;
        assert_eq!([2, 4, 8, 30].map(least_s), [0.4, 0.8, 1.0, 3.0]);
        assert_eq!(least_ns(S, S), 3 * S);
    }
}
