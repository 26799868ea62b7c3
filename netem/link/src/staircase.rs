//! One direction of a link as settings of tc's netem: the first setting, and each change with its link time.
//!
//! Pure functions. netem holds a constant state, so a link that varies in time is played as a
//! staircase. A level is set exactly; a fall, during which packets wait in order, is followed in
//! steps of [`STEP_NS`]. Passing the changes to tc, and how late that is, are the task of others.

use crate::path::{Path, State};
use crate::profile::{Order, PathLaw, Profile};
use crate::setting::{Pace, Setting};
use crate::time::LinkTime;
use crate::way::Way;

/// The step in which a falling delay is followed. Such a delay falls by one second per second, so the
/// played delay is off by at most half a step. Shorter steps are more than tc can do on every
/// machine: a change takes some ten microseconds, but in User-Mode Linux, the slowest machine tried,
/// more than a millisecond, and there are two ways to play.
pub const STEP_NS: u64 = 2_000_000;

/// Interval at which the link's state is read, so the most by which a change is late and the least
/// time between two. It divides the millisecond in which loss is decided.
pub const READING_NS: u64 = 125_000;

/// A level that is closer than this to the current setting is not worth a change.
const CLOSE_NS: u64 = 10_000;

/// netem needs room for this many packets a second over the longest delay, besides the profile's own
/// queue. A client at 1 kHz whose packets wait for the end of a stall sends five thousand a second,
/// including acknowledgements and retransmissions.
const PACKETS_PER_S: u64 = 10_000;

/// Several seconds of any loop's packets. A player that reads the counters once a second and sees
/// fewer packets than this knows that none was dropped for lack of room, however short the delay.
/// With tc's default of 1000 it could not tell.
const LEAST_LIMIT: u32 = 20_000;

/// A million packets of 1500 bytes: more than a machine should hold for a link.
const GREATEST_LIMIT: u32 = 1_000_000;

/// A setting and the instant from which it applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// When it starts to apply.
    pub at: LinkTime,
    /// The setting from then on.
    pub setting: Setting,
}

/// The changes of one direction, in order.
#[derive(Debug, Clone)]
pub struct Staircase {
    path: Path,
    ordered: bool,
    limit: u32,
    /// The next instant at which the state is read.
    reading: LinkTime,
    /// The state at that instant, computed in advance.
    state: State,
    setting: Option<Setting>,
}

impl Staircase {
    /// The changes of one direction of the link of `profile` and `seed`, from link time 0 on.
    ///
    /// A rate limit implies order in netem, so a profile that has one is played in order even if its
    /// order is free.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64, way: Way) -> Self {
        let law = profile.law(way);
        let mut path = Path::new(law, way, seed);
        Self {
            state: path.state_at(LinkTime::ZERO),
            path,
            ordered: law.order == Order::Kept,
            limit: limit(law),
            reading: LinkTime::ZERO,
            setting: None,
        }
    }

    /// The next change before `end`; the first is that of time 0. `None` if there is none; a later
    /// `end` may then find more.
    ///
    /// A constant link changes once and never again, so the search needs an end.
    pub fn next_before(&mut self, end: LinkTime) -> Option<Change> {
        while self.reading < end {
            let (at, now) = (self.reading, self.state);
            self.reading = at.after(READING_NS);
            self.state = self.path.state_at(self.reading);
            let setting = self.setting_for(at, now, self.state);
            if let Some(setting) = setting {
                self.setting = Some(setting);
                return Some(Change { at, setting });
            }
        }
        None
    }

    /// The setting to change to for the state `now` at `at`, given the next state `soon`; `None`
    /// without a change.
    fn setting_for(&mut self, at: LinkTime, now: State, soon: State) -> Option<Setting> {
        let fall_ns = now.delay_ns.saturating_sub(soon.delay_ns);
        let falling = fall_ns > 0 && fall_ns <= READING_NS;
        // Half a step below the current delay is half a step above the delay at the end of the step.
        // The change comes at the last reading before it would be further off.
        let (aim_ns, close_ns) = if falling {
            (self.half_a_step_on(at, now), STEP_NS / 2 - READING_NS)
        } else {
            (now.delay_ns, CLOSE_NS)
        };
        let pace = match (now.rate_bps, self.ordered) {
            (Some(rate_bps), _) => Pace::Limited(rate_bps.max(1)),
            (None, true) => Pace::Ordered,
            (None, false) => Pace::Free,
        };
        let setting = |delay_ns| Setting {
            delay_us: Setting::delay_us(delay_ns),
            lost: now.lost,
            pace,
            limit: self.limit,
        };
        let Some(before) = self.setting else {
            return Some(setting(aim_ns));
        };
        let apart_us = before.delay_us.abs_diff(Setting::delay_us(now.delay_ns));
        let close = u64::from(apart_us) * 1000 <= close_ns;
        let setting = if close {
            Setting {
                delay_us: before.delay_us,
                ..setting(aim_ns)
            }
        } else {
            setting(aim_ns)
        };
        (setting != before).then_some(setting)
    }

    /// The delay that a fall in the state `now` reaches after half a step, or where it ends before that.
    fn half_a_step_on(&mut self, at: LinkTime, now: State) -> u64 {
        const HALF_NS: u64 = STEP_NS / 2;
        let then = self.path.state_at(at.after(HALF_NS));
        let lowest_ns = now.delay_ns.saturating_sub(HALF_NS);
        then.delay_ns.clamp(lowest_ns, now.delay_ns)
    }
}

/// How many packets netem may hold. Unlike the model's, its count includes packets on the wire, so
/// room for these is added to the profile's queue.
fn limit(law: &PathLaw) -> u32 {
    const NS_PER_S: u128 = 1_000_000_000;
    /// A full-size packet, as sent by a flow that fills the queue.
    const PACKET_BITS: u128 = 1500 * 8;
    let stall_ns = law.stall.as_ref().map_or(0.0, |s| s.length.reach_ns());
    let longest_ns = u128::from(law.reach_ns()) + stall_ns as u128;
    let waiting = longest_ns * u128::from(PACKETS_PER_S) / NS_PER_S;
    let fit = |packets: u128| {
        u32::try_from(packets)
            .unwrap_or(u32::MAX)
            .min(GREATEST_LIMIT)
    };
    match &law.rate {
        None => fit(waiting).max(LEAST_LIMIT),
        Some(rate) => {
            let rate_bps = u128::from(rate.greatest_bps(&law.delay));
            let on_wire = longest_ns * rate_bps / PACKET_BITS / NS_PER_S;
            fit(on_wire.max(waiting) + u128::from(rate.limit()))
        }
    }
}
