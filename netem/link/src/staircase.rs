//! One direction of a link as settings of tc's netem: the first, and each change with its
//! link time.
//!
//! Pure. netem holds a constant state, so a link in time is played as a staircase. A level
//! is set exactly; a fall, in which packets wait in order for something, is followed in
//! steps of [`STEP_NS`]. Who gives the changes to tc, and how late, is not said here.

use crate::path::{Path, State};
use crate::profile::{Order, PathLaw, Profile};
use crate::setting::{Pace, Setting};
use crate::way::Way;

/// The step of a falling delay, which falls by a second each second: no instant of it is
/// played more than half of this off. Shorter steps would say more than tc can do everywhere:
/// a change costs some ten microseconds, but in User-Mode Linux, the slowest machine tried,
/// more than a millisecond, and there are two ways to play.
pub const STEP_NS: u64 = 2_000_000;

/// The link's state is read this often, so this is the most by which a change comes late,
/// and the least time between two. It divides the millisecond in which loss is decided.
pub const READING_NS: u64 = 125_000;

/// A level that is closer than this to the setting in force is not worth a change.
const CLOSE_NS: u64 = 10_000;

/// What a netem must have room for besides the profile's own queue: this many packets a
/// second for as long as the longest delay. A client at 1 kHz whose packets wait for the end
/// of a stall sends five thousand a second, its acknowledgements and repetitions included.
const PACKETS_PER_S: u64 = 10_000;

/// Several seconds of any loop's packets. So who reads the counters once a second and sees
/// that fewer have come knows that none was dropped for lack of room, however short the
/// delay. tc's own default of 1000 would not tell.
const LEAST_LIMIT: u32 = 20_000;

/// A million packets of 1500 bytes: more than a machine should hold for a link.
const GREATEST_LIMIT: u32 = 1_000_000;

/// A setting and the link time from which on it is in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Link time in ns.
    pub t_ns: u64,
    /// The setting from then on.
    pub setting: Setting,
}

/// The changes of one direction, in their order.
#[derive(Debug, Clone)]
pub struct Staircase {
    path: Path,
    ordered: bool,
    limit: u32,
    /// The next instant at which the state is read.
    reading_ns: u64,
    /// The state there, which is known beforehand.
    state: State,
    setting: Option<Setting>,
}

impl Staircase {
    /// The changes of one direction of the link of `profile` and `seed`, from link time 0 on.
    ///
    /// A rate limit implies order in netem. A profile that has one and whose order is free
    /// is played in order.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64, way: Way) -> Self {
        let law = profile.law(way);
        let mut path = Path::new(law, way, seed);
        Self {
            state: path.state_at(0),
            path,
            ordered: law.order == Order::Kept,
            limit: limit(law),
            reading_ns: 0,
            setting: None,
        }
    }

    /// The next change before link time `end_ns`, the first one being that of time 0. `None`
    /// when there is none; a later end may then show more.
    ///
    /// A link that is constant changes once and never again, which is why there has to be an
    /// end to the looking.
    pub fn next_before(&mut self, end_ns: u64) -> Option<Change> {
        while self.reading_ns < end_ns {
            let (t_ns, now) = (self.reading_ns, self.state);
            self.reading_ns = t_ns.saturating_add(READING_NS);
            self.state = self.path.state_at(self.reading_ns);
            let setting = self.setting_for(t_ns, now, self.state);
            if let Some(setting) = setting {
                self.setting = Some(setting);
                return Some(Change { t_ns, setting });
            }
        }
        None
    }

    /// The setting to change to in the state `now` of `t_ns`, if it is one, with `soon`
    /// coming.
    fn setting_for(&mut self, t_ns: u64, now: State, soon: State) -> Option<Setting> {
        let fall_ns = now.delay_ns.saturating_sub(soon.delay_ns);
        let falling = fall_ns > 0 && fall_ns <= READING_NS;
        // Half a step below the delay now is half a step above that at the step's end. The
        // change comes at the last reading before it would be further off.
        let (aim_ns, close_ns) = if falling {
            (self.half_a_step_on(t_ns, now), STEP_NS / 2 - READING_NS)
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

    /// Where a fall that is under way in the state `now` has come to after half a step, or
    /// ended before.
    fn half_a_step_on(&mut self, t_ns: u64, now: State) -> u64 {
        const HALF_NS: u64 = STEP_NS / 2;
        let then = self.path.state_at(t_ns.saturating_add(HALF_NS));
        let lowest_ns = now.delay_ns.saturating_sub(HALF_NS);
        then.delay_ns.clamp(lowest_ns, now.delay_ns)
    }
}

/// How many packets netem may hold. Its count includes those on the wire, which the model's
/// does not: so room for these is added to the profile's queue.
fn limit(law: &PathLaw) -> u32 {
    const NS_PER_S: u128 = 1_000_000_000;
    /// A full packet, as a flow has them that fills the queue.
    const PACKET_BITS: u128 = 1500 * 8;
    let stall_ns = law.stall.as_ref().map_or(0.0, |s| s.length.reach_ns());
    let longest_ns = u128::from(law.delay.reach_ns()) + stall_ns as u128;
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
