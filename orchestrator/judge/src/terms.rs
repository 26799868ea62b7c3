//! What a link should do to a message, and how long programs are busy when it stalls.
//!
//! A message is stamped shortly before its first packet enters, so the link is examined over a window
//! of time. `crossing` compares the messages with the result.

use std::ops::Range;

use link::{Stay, Stretch, Timeline, Way};

use crate::busy::Busy;
use crate::connecting::Connecting;
use crate::glances::{Glances, LOOK_NS};
use crate::hit::Hits;
use crate::limit::{
    Allowance, DRAIN_MS, DRAIN_SHARE, FLOOR_AT_MOST, FLOOR_PER_COST, STALL_LOOK_NS, STALL_MS,
    TAILS, Tail, WORK_TIMES, WORK_UNSEEN_MS,
};
use crate::milliseconds::{ms, ns};
use crate::still::{Still, Times};

/// Smallest IP length of a request or an answer, bytes; it is longer than an echo's. It matters if
/// there is a rate limit: then the packets that entered are known, and the first one of at least this
/// length is taken to be the message.
pub(crate) const MESSAGE_BYTES: u32 = 90;
/// IP length of a handshake's packet, bytes.
const HANDSHAKE_BYTES: u32 = 60;

/// How far ahead to look for the end of an outage, ns: a message that comes within this time of it is too
/// quick for any client.
const OUTAGE_NS: u64 = 250_000_000;

/// What is needed to judge messages.
#[derive(Debug)]
pub struct Terms {
    /// The link that was asked for.
    pub timeline: Timeline,
    /// The time of the run, monotonic ns: rows that a client stamped outside it are counted, but not
    /// used.
    pub run_ns: Range<u64>,
    /// How long a packet may still meet a state of the link that has ended, ns; it depends on the
    /// player.
    pub before_ns: u64,
    /// How far a falling delay may be off, ns; it depends on the player too.
    pub fall_ns: u64,
    /// Cost of crossing the player itself, up and down, ms.
    pub baseline_ms: [f64; 2],
    /// What the client is allowed.
    pub allowance: Allowance,
    /// How the client comes by its connections.
    pub connecting: Connecting,
    /// Whether the link has a rate limit.
    pub has_rate: bool,
    /// When a client gives a message up, after its sending, ms: what comes later is not taken.
    pub timeout_ms: f64,
    /// How busy the machine was, by what no link can touch.
    pub busy: Busy,
    /// Sample time, ms; it says how many messages wait in a stall.
    pub h_ms: f64,
    /// When a processor stood still.
    pub still: Still,
    /// When faults that the experiment asked for hit the ends.
    pub hits: Hits,
}

/// When a packet that enters within a window leaves, and the probability that it is lost.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    pub(crate) earliest_ns: u64,
    pub(crate) latest_ns: u64,
    /// The longest that the link delays one that enters within the window, ns.
    pub(crate) slowest_ns: u64,
    pub(crate) lossy: f64,
}

impl Terms {
    /// If nine of ten messages take more than this on a way in addition to the link, ms, something else
    /// delays them on this machine.
    pub(crate) fn floor_ms(&self, way: Way, count: u64) -> f64 {
        let usual_ms = self.usual_ms(way);
        let opening_ms = match (self.connecting, way) {
            (Connecting::Each | Connecting::Own { .. }, Way::Up) => self.allowance.opening_ms,
            _ => 0.0,
        };
        self.slow(way) * usual_ms + opening_ms + self.work_ms(count)
    }

    /// How long the client and the kernels need for a message on a quiet machine, ms.
    fn usual_ms(&self, way: Way) -> f64 {
        match way {
            Way::Up => self.allowance.up_floor_ms,
            Way::Down => self.allowance.down_floor_ms,
        }
    }

    /// How many times slower this machine may be than a quiet one, by what it takes for the empty link.
    fn slow(&self, way: Way) -> f64 {
        let cost_ms = self.baseline_ms[way as usize].max(0.0);
        (1.0 + FLOOR_PER_COST * cost_ms / self.usual_ms(way)).min(FLOOR_AT_MOST)
    }

    /// The time that a program of one's own takes for one of so many messages beyond that of webloop's, ms: between
    /// its stamp and its sending it may do anything that takes processor time, as starting another program does.
    pub(crate) fn work_ms(&self, count: u64) -> f64 {
        match self.connecting {
            Connecting::Own { .. } => {
                let each_ms = self.busy.work_each_ms(count as usize);
                each_ms.map_or(WORK_UNSEEN_MS, |each_ms| WORK_TIMES * each_ms)
            }
            _ => 0.0,
        }
    }

    /// How many of `count` messages the machine may have made late by more than `late_ms`: any, where it had no time
    /// for a program of one's own, whose work between its stamp and its sending takes then as long as it takes.
    pub(crate) fn busy_explains(&self, count: u64, late_ms: f64) -> f64 {
        match self.is_crowded_out() {
            true => f64::INFINITY,
            false => self.busy.explains(count as usize, late_ms),
        }
    }

    /// How long each of `count` messages waited for a processor, ms, if they waited alike; there without a limit.
    pub(crate) fn waited_each_ms(&self, count: u64) -> f64 {
        match self.is_crowded_out() {
            true => f64::INFINITY,
            false => self.busy.waited_each_ms(count as usize),
        }
    }

    fn is_crowded_out(&self) -> bool {
        matches!(self.connecting, Connecting::Own { .. }) && self.busy.is_crowded()
    }

    /// How many of `count` messages may be later than the quickest, and by how much, on this machine.
    pub(crate) fn tail(&self, way: Way, count: u64) -> [Tail; TAILS] {
        let (slow, work_ms) = (self.slow(way), self.work_ms(count));
        self.allowance.tail.map(|step| Tail {
            beyond_ms: slow * step.beyond_ms + work_ms,
            ..step
        })
    }

    /// The window of a packet that enters a way within `within_ns` after `t_ns`. It has `bytes`; for a
    /// message, the length of the packet that entered is used instead, if it is known.
    pub(crate) fn window(
        &self,
        link: &mut Timeline,
        way: Way,
        t_ns: u64,
        within_ns: u64,
        bytes: u32,
    ) -> Window {
        let bytes = entered_bytes(link, way, t_ns, within_ns, bytes);
        let (mut earliest_ns, mut latest_ns, mut slowest_ns) = (u64::MAX, 0, 0);
        let (mut count, mut lossy) = (0_u32, 0_u32);
        let mut looks = self.looks(t_ns, within_ns);
        // What the link does in a piece is asked once, though looks before and in the window are taken apart.
        let mut asked: Option<Stretch> = None;
        while let Some(look_ns) = looks.next_ns() {
            let known = asked.filter(|piece| look_ns < piece.delays.end_ns);
            let piece = known.unwrap_or_else(|| {
                let ended_ns = asked.map(|piece| piece.delays.end_ns);
                let first_ns = first_out_ns(link, way, bytes, ended_ns, look_ns, t_ns);
                earliest_ns = earliest_ns.min(first_ns);
                link.piece(way, look_ns, bytes)
            });
            asked = Some(piece);
            let looks = looks.take(look_ns, piece.delays.end_ns);
            // In a piece a delay only falls, and by no more than time goes on: so one of these is the extreme.
            for look_ns in [looks.first_ns, looks.last_ns] {
                let delay_ns = piece.delays.delay_ns(look_ns);
                let leaves_ns = look_ns.max(t_ns).saturating_add(delay_ns);
                earliest_ns = earliest_ns.min(leaves_ns);
                if !looks.is_before {
                    latest_ns = latest_ns.max(match piece.queued {
                        // The length of the queue is unknown.
                        true => u64::MAX,
                        false => leaves_ns,
                    });
                    slowest_ns = slowest_ns.max(delay_ns);
                }
            }
            if !looks.is_before {
                count += looks.count;
                lossy += looks.count * u32::from(piece.lost);
            }
        }
        Window {
            earliest_ns: earliest_ns.saturating_sub(self.fall_ns),
            latest_ns: latest_ns.saturating_add(self.fall_ns),
            slowest_ns: slowest_ns.saturating_add(self.fall_ns),
            lossy: f64::from(lossy) / f64::from(count.max(1)),
        }
    }

    /// The earliest of [`Terms::window`] for a message, where nothing else of it is asked.
    pub(crate) fn earliest_ns(
        &self,
        link: &mut Timeline,
        way: Way,
        t_ns: u64,
        within_ns: u64,
    ) -> u64 {
        let bytes = entered_bytes(link, way, t_ns, within_ns, MESSAGE_BYTES);
        let mut earliest_ns = u64::MAX;
        let mut looks = self.looks(t_ns, within_ns);
        let mut asked: Option<Stay> = None;
        while let Some(look_ns) = looks.next_ns() {
            let known = asked.filter(|delays| look_ns < delays.end_ns);
            let delays = known.unwrap_or_else(|| {
                let ended_ns = asked.map(|delays| delays.end_ns);
                let first_ns = first_out_ns(link, way, bytes, ended_ns, look_ns, t_ns);
                earliest_ns = earliest_ns.min(first_ns);
                link.delays(way, look_ns, bytes)
            });
            asked = Some(delays);
            let looks = looks.take(look_ns, delays.end_ns);
            for look_ns in [looks.first_ns, looks.last_ns] {
                let leaves_ns = look_ns.max(t_ns).saturating_add(delays.delay_ns(look_ns));
                earliest_ns = earliest_ns.min(leaves_ns);
            }
        }
        earliest_ns.saturating_sub(self.fall_ns)
    }

    /// When to look at the link for a packet that enters within `within_ns` after `t_ns`.
    fn looks(&self, t_ns: u64, within_ns: u64) -> Glances {
        // The stamp itself may be off: then the message may have met an earlier state, and be quicker.
        let from_ns = t_ns.saturating_sub(self.before_ns);
        let begins_ns = from_ns.saturating_sub(ns(self.allowance.clock_ms));
        Glances::new(begins_ns, &(from_ns..=t_ns.saturating_add(within_ns)), t_ns)
    }

    /// When the link carries packets again, ns, if it loses every packet that enters a way from `t_ns` to
    /// `within_ns` later; else 0. No message of then leaves before.
    pub(crate) fn carries_again_ns(
        &self,
        link: &mut Timeline,
        way: Way,
        t_ns: u64,
        within_ns: u64,
    ) -> u64 {
        let from_ns = t_ns.saturating_sub(self.before_ns);
        let mut look_ns = from_ns.saturating_sub(ns(self.allowance.clock_ms));
        let last_ns = t_ns.saturating_add(within_ns);
        let until_ns = last_ns.saturating_add(OUTAGE_NS);
        while look_ns <= until_ns && link.passage(way, look_ns, MESSAGE_BYTES).lost {
            look_ns = look_ns.saturating_add(LOOK_NS);
        }
        match look_ns > last_ns {
            // It may have been open since the look before.
            true => look_ns.saturating_sub(LOOK_NS),
            false => 0,
        }
    }

    /// When a message for which a connection is opened leaves the way up at the latest: its handshake
    /// crosses the link both ways first.
    pub(crate) fn opened(&self, link: &mut Timeline, t_ns: u64, within_ns: u64) -> Window {
        let syn = self.window(link, Way::Up, t_ns, within_ns, HANDSHAKE_BYTES);
        if syn.latest_ns == u64::MAX {
            // Nothing is late behind a queue of unknown length.
            return syn;
        }
        // Its answer leaves between these, and so on.
        let between = |from: &Window, within_ns: u64| {
            let spread_ns = from.latest_ns.saturating_sub(from.earliest_ns);
            (from.earliest_ns, spread_ns.saturating_add(within_ns))
        };
        let (from_ns, width_ns) = between(&syn, LOOK_NS);
        let back = self.window(link, Way::Down, from_ns, width_ns, HANDSHAKE_BYTES);
        if back.latest_ns == u64::MAX {
            return back;
        }
        let (from_ns, width_ns) = between(&back, within_ns);
        let up = self.window(link, Way::Up, from_ns, width_ns, MESSAGE_BYTES);
        let kept = (1.0 - syn.lossy) * (1.0 - back.lossy) * (1.0 - up.lossy);
        Window {
            slowest_ns: syn.slowest_ns + back.slowest_ns + up.slowest_ns,
            lossy: 1.0 - kept,
            ..up
        }
    }

    /// The probability that a packet of such a message or of its handshake is lost, wherever they stray
    /// to. Each enters when the one before it has left, at any time at which that may have been.
    pub(crate) fn opened_lossy(&self, link: &mut Timeline, t_ns: u64, within_ns: u64) -> f64 {
        let stray_ns = ns(self.allowance.strays_within_ms);
        let (mut from_ns, mut width_ns, mut kept) = (t_ns, stray_ns, 1.0);
        for (way, bytes) in [
            (Way::Up, HANDSHAKE_BYTES),
            (Way::Down, HANDSHAKE_BYTES),
            (Way::Up, MESSAGE_BYTES),
        ] {
            let window = self.window(link, way, from_ns, width_ns, bytes);
            kept *= 1.0 - window.lossy;
            let spread_ns = window.latest_ns.saturating_sub(window.earliest_ns);
            from_ns = window.earliest_ns;
            width_ns = spread_ns.saturating_add(within_ns).min(stray_ns);
        }
        1.0 - kept
    }
}

/// When a packet leaves, not before `t_ns`, that enters as soon as a piece of the link has ended and before the next
/// look. Where packets overtake each other, it may be out before those of both looks; else `u64::MAX`.
fn first_out_ns(
    link: &mut Timeline,
    way: Way,
    bytes: u32,
    ended_ns: Option<u64>,
    look_ns: u64,
    t_ns: u64,
) -> u64 {
    match ended_ns {
        Some(ended_ns) if ended_ns < look_ns && link.may_overtake(way) => {
            let delays = link.delays(way, ended_ns, bytes);
            ended_ns.max(t_ns).saturating_add(delays.delay_ns(ended_ns))
        }
        _ => u64::MAX,
    }
}

/// The length of a packet that enters a way within `within_ns` after `t_ns`: `bytes`, or for a message that of the
/// packet that did, if it is known.
fn entered_bytes(link: &Timeline, way: Way, t_ns: u64, within_ns: u64, bytes: u32) -> u32 {
    let entered = match bytes {
        MESSAGE_BYTES => link.bytes_entered(way, t_ns, within_ns, bytes),
        _ => None,
    };
    entered.unwrap_or(bytes)
}

/// The times when the link stalls, and when programs are busy with what it then releases.
#[derive(Debug)]
pub(crate) struct Swamped(Times);

impl Swamped {
    /// Finds them for the link of a run.
    pub(crate) fn of(terms: &Terms) -> Swamped {
        let mut link = terms.timeline.clone();
        // A message waits for each h, and the client has to read each of them.
        let share = DRAIN_SHARE + terms.allowance.message_ms / terms.h_ms;
        let mut found = Times::default();
        let mut look_ns = terms.run_ns.start;
        while look_ns < terms.run_ns.end {
            let mut delay_ns = |way| link.passage(way, look_ns, MESSAGE_BYTES).delay_ns;
            let delay_ns = delay_ns(Way::Up).max(delay_ns(Way::Down));
            if delay_ns > ns(STALL_MS) {
                let drain_ms = DRAIN_MS + share * ms(delay_ns);
                found.join(look_ns..look_ns + delay_ns + ns(drain_ms));
            }
            look_ns += STALL_LOOK_NS;
        }
        Swamped(found)
    }

    /// Whether an instant is in one of these times.
    pub(crate) fn contains(&self, t_ns: u64) -> bool {
        self.0.contains(t_ns)
    }
}

#[cfg(test)]
mod tests {
    use link::{Epoch, Profile};
    use plan::Client;

    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_window_of_any_client_finds_each_millisecond_in_which_the_link_loses() {
        let source = "name = \"lossy\"\nabout = \"1 ms and loss\"\n[both.delay]\nbase = \"1ms\"\n[both.loss.random]\nshare = \"2%\"\n";
        let (profile, _) = Profile::read(source, "lossy", &|_: &str| Err(String::new()));
        let profile = profile.expect("a profile");
        let terms = |client: Client| Terms {
            timeline: Timeline::new(&profile, 1, Epoch::default()),
            run_ns: 0..u64::MAX,
            before_ns: 0,
            fall_ns: 0,
            baseline_ms: [0.0; 2],
            allowance: client.spec().allowance,
            connecting: Connecting::Pool { accepted: None },
            has_rate: false,
            timeout_ms: 5_000.0,
            busy: Busy::default(),
            h_ms: 10.0,
            still: Still::default(),
            hits: Hits::default(),
        };
        for client in Client::ALL {
            let terms = terms(client);
            let within_ns = ns(terms.allowance.strays_within_ms);
            let mut lost = terms.timeline.clone();
            let mut link = terms.timeline.clone();
            for k in 100..3_000 {
                let lost_ns = k * MS + 300_000;
                if !lost.passage(Way::Up, lost_ns, 100).lost {
                    continue;
                }
                // It begins anywhere before.
                let from_ns = lost_ns.saturating_sub(k * 7_919_377 % within_ns);
                let window = terms.window(&mut link, Way::Up, from_ns, within_ns, MESSAGE_BYTES);
                assert!(window.lossy > 0.0, "{client}, millisecond {k}");
            }
        }
    }
}
