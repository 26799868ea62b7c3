//! What a loop waited for from instant to instant, while nothing newer came.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::Range;

use super::message::Message;
use super::traffic::Traffic;
use super::{Cause, Facts, Stamps};

/// What is waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Goal {
    /// A newer command in effect: of a message behind this place in the order of sending; of any without one.
    Effect(Option<usize>),
    /// An answer with the y of a tick after this one; any without one.
    Answer(Option<u64>),
}

/// A stretch of a run, cut into parts as it goes on.
#[derive(Debug)]
pub(super) struct Walk<'a> {
    traffic: &'a Traffic,
    /// When a tick was due that had not come yet, in order, apart.
    late: &'a [Range<u64>],
    facts: &'a Facts,
    at_ns: u64,
    end_ns: u64,
    pub(super) parts_ns: [u64; 9],
    /// Of the link's part, that of the way up.
    pub(super) up_ns: u64,
}

/// Where a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Up,
    Down,
    Other(Cause),
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        traffic: &'a Traffic,
        late: &'a [Range<u64>],
        facts: &'a Facts,
        time_ns: Range<u64>,
    ) -> Walk<'a> {
        Walk {
            traffic,
            late,
            facts,
            at_ns: time_ns.start,
            end_ns: time_ns.end,
            parts_ns: [0; 9],
            up_ns: 0,
        }
    }

    /// Goes on to an instant: what is walked so far is never walked again.
    pub(super) fn go(&mut self, t_ns: u64, cause: Cause) {
        let to_ns = t_ns.min(self.end_ns).max(self.at_ns);
        let whole_ns = to_ns - self.at_ns;
        // What waits at an end waits for the plant, if the plant stands still.
        let waits = matches!(
            cause,
            Cause::Sampling | Cause::Ends | Cause::Queue | Cause::Connection | Cause::Untold
        );
        let plant_ns = if waits {
            covered_ns(self.late, self.at_ns..to_ns)
        } else {
            0
        };
        self.parts_ns[Cause::Plant as usize] += plant_ns;
        self.parts_ns[cause as usize] += whole_ns - plant_ns;
        self.at_ns = to_ns;
    }

    fn go_by_place(&mut self, t_ns: u64, place: Place) {
        let before_ns = self.at_ns;
        match place {
            Place::Up => {
                self.go(t_ns, Cause::Link);
                self.up_ns += self.at_ns - before_ns;
            }
            Place::Down => self.go(t_ns, Cause::Link),
            Place::Other(cause) => self.go(t_ns, cause),
        }
    }

    /// Goes along a message's way up, to its arrival.
    pub(super) fn up(&mut self, one: &Message) {
        self.go_by_place(one.send_ns.saturating_add(one.up_ns), Place::Up);
        self.go_late(one.arrive_ns, one.up_late);
    }

    /// Goes along the way of an answer, to its receiver.
    pub(super) fn down(&mut self, one: &Message) {
        let arrive_ns = one.arrive_ns.unwrap_or(one.send_ns);
        self.go_by_place(arrive_ns.saturating_add(one.down_ns), Place::Down);
        self.go_late(one.receive_ns, one.down_late);
    }

    /// Goes on through what is later than the link: the controller's, unless the plant stood still meanwhile.
    fn go_late(&mut self, t_ns: Option<u64>, cause: Cause) {
        let Some(t_ns) = t_ns else { return };
        if cause != Cause::Controller {
            return self.go(t_ns, cause);
        }
        let to_ns = t_ns.min(self.end_ns).max(self.at_ns);
        let plant_ns = covered_ns(self.late, self.at_ns..to_ns);
        self.go(to_ns, Cause::Controller);
        self.parts_ns[Cause::Controller as usize] -= plant_ns;
        self.parts_ns[Cause::Plant as usize] += plant_ns;
    }

    /// Goes on to an instant by what was waited for meanwhile.
    pub(super) fn wait(&mut self, t_ns: u64, goal: Goal) {
        let to_ns = t_ns.min(self.end_ns);
        if to_ns <= self.at_ns {
            return;
        }
        let messages = &self.traffic.messages;
        let from_ns = self.at_ns;
        let touches =
            |one: &Message| one.send_ns < to_ns && one.over_ns(self.facts.timeout_ns) > from_ns;
        let mut open: Vec<usize> = (0..messages.len())
            .filter(|at| touches(&messages[*at]))
            .collect();
        let cuts = self.cuts(&open, from_ns..to_ns);
        open.reverse();
        let (mut hopes, mut under_way) = (BinaryHeap::new(), BTreeSet::new());
        let mut is_there = false;
        for cut in cuts.windows(2) {
            let t_ns = cut[0];
            while let Some(at) = open.pop_if(|at| messages[*at].send_ns <= t_ns) {
                under_way.insert(at);
                if let Some(done_ns) = done_ns(&messages[at], at, goal) {
                    hopes.push(Reverse((done_ns, at)));
                }
            }
            while let Some(Reverse((done_ns, at))) = hopes.peek().copied() {
                if done_ns > t_ns {
                    break;
                }
                hopes.pop();
                is_there |= matches!(goal, Goal::Effect(_)) && messages[at].is_taken;
            }
            let place = match hopes.peek() {
                _ if is_there => Place::Other(Cause::Sampling),
                Some(Reverse((_, at))) => place(&messages[*at], t_ns),
                None => self.unsent(t_ns, goal, &mut under_way),
            };
            match place {
                Place::Other(Cause::Controller) if !hopes.is_empty() => {
                    self.go_late(Some(cut[1]), Cause::Controller);
                }
                place => self.go_by_place(cut[1], place),
            }
        }
    }

    /// The instants in a time at which something changes, and both its ends.
    fn cuts(&self, open: &[usize], time_ns: Range<u64>) -> Vec<u64> {
        let half_ns = self.facts.h_ns / 2;
        let mut cuts = vec![time_ns.start, time_ns.end];
        for at in open {
            let one = &self.traffic.messages[*at];
            cuts.extend([one.send_ns, one.send_ns.saturating_add(one.up_ns)]);
            cuts.extend(one.arrive_ns);
            cuts.extend(one.arrive_ns.map(|t_ns| t_ns.saturating_add(one.down_ns)));
            cuts.push(one.over_ns(self.facts.timeout_ns));
        }
        let first_ns = time_ns.start.saturating_sub(2 * self.facts.h_ns);
        for one in self.traffic.due(first_ns, time_ns.end) {
            let patience_ns = one.due_ns.saturating_add(self.facts.h_ns + half_ns);
            cuts.extend([one.due_ns, patience_ns]);
        }
        cuts.retain(|t_ns| (time_ns.start..=time_ns.end).contains(t_ns));
        cuts.sort_unstable();
        cuts.dedup();
        cuts
    }

    /// Why nothing is under way that brings what is waited for.
    fn unsent(&self, t_ns: u64, goal: Goal, under_way: &mut BTreeSet<usize>) -> Place {
        let messages = &self.traffic.messages;
        let deadlines = &self.traffic.deadlines;
        let behind = deadlines.partition_point(|one| one.due_ns <= t_ns);
        let Some(last) = behind.checked_sub(1).and_then(|at| deadlines.get(at)) else {
            let is_early = t_ns < self.facts.start_ns.saturating_add(self.facts.h_ns);
            let cause = if is_early {
                Cause::Sampling
            } else {
                Cause::Controller
            };
            return Place::Other(cause);
        };
        let sent = last.message.map(|at| &messages[at]);
        let sent = sent.filter(|one| one.send_ns <= t_ns);
        let is_lost = |one: &Message| match goal {
            Goal::Effect(_) => one.arrive_ns.is_none(),
            Goal::Answer(_) => one.arrive_ns.is_none() || one.receive_ns.is_none(),
        };
        if sent.is_some_and(is_lost) {
            return Place::Other(Cause::Loss);
        }
        let patience_ns = self.facts.h_ns + self.facts.h_ns / 2;
        if sent.is_some() && t_ns.saturating_sub(last.due_ns) < patience_ns {
            return Place::Other(Cause::Sampling);
        }
        under_way.retain(|at| messages[*at].over_ns(self.facts.timeout_ns) > t_ns);
        let first = under_way.first().map(|at| &messages[*at]);
        match first.filter(|_| under_way.len() >= self.facts.outstanding.limit()) {
            Some(awaited) if self.is_slow(awaited) => place(awaited, t_ns),
            Some(_) => Place::Other(Cause::Queue),
            None if self.traffic.stamps == Stamps::None => Place::Other(Cause::Untold),
            None => Place::Other(Cause::Controller),
        }
    }

    /// Whether a message took more than twice as long as half of them.
    fn is_slow(&self, one: &Message) -> bool {
        let took_ns = one.receive_ns.map(|t_ns| t_ns.saturating_sub(one.send_ns));
        took_ns.is_none_or(|ns| ns / 2 > self.traffic.round_trip_ns)
    }
}

/// When a message brings what is waited for; `None` if it never does.
fn done_ns(one: &Message, at: usize, goal: Goal) -> Option<u64> {
    match goal {
        Goal::Effect(behind) => one.arrive_ns.filter(|_| behind.is_none_or(|it| at > it)),
        Goal::Answer(known) => one.receive_ns.filter(|_| one.tick > known),
    }
}

/// Where a message is at an instant at which it is under way.
fn place(one: &Message, t_ns: u64) -> Place {
    let Some(arrive_ns) = one.arrive_ns else {
        return Place::Other(Cause::Loss);
    };
    if t_ns < one.send_ns.saturating_add(one.up_ns) {
        Place::Up
    } else if t_ns < arrive_ns {
        Place::Other(one.up_late)
    } else if one.receive_ns.is_none() {
        Place::Other(Cause::Loss)
    } else if t_ns < arrive_ns.saturating_add(one.down_ns) {
        Place::Down
    } else {
        Place::Other(one.down_late)
    }
}

/// How much of a time lies within some ranges, which are in order and apart, ns.
fn covered_ns(ranges: &[Range<u64>], time_ns: Range<u64>) -> u64 {
    let first = ranges.partition_point(|one| one.end <= time_ns.start);
    let inside = ranges[first..]
        .iter()
        .take_while(|one| one.start < time_ns.end);
    inside
        .map(|one| one.end.min(time_ns.end) - one.start.max(time_ns.start))
        .sum()
}
