//! What each echo of a probe should have met: the timeline of the same profile and seed,
//! asked at the instants at which the echo entered it.
//!
//! Pure. Only the part of a link that depends on other traffic, the queue in front of a rate
//! limit, cannot be predicted so; the prediction is then the least that the delay can be.

use link::Way;
use serde::{Deserialize, Serialize};

use crate::icmp::PACKET_BYTES;
use crate::probe::Echo;
use crate::statistics::{median, ms};
use crate::timeline::Timeline;

/// A packet enters the link a few microseconds after the instant that is known of it: after
/// the time at which it was handed to the kernel, or reached the plant that answers. If the
/// link's state changes within this time, the state after the change is as good a prediction
/// as the one before it.
const EDGE_NS: u64 = 200_000;

/// What a packet should meet on one way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Its delay, ns.
    pub delay_ns: u64,
    /// Its delay if it enters after a step of the delay that was about to come.
    pub delay_after_step_ns: Option<u64>,
    /// Whether it is lost.
    pub lost: bool,
    /// Whether that was about to change, so that either fate is as predicted.
    pub either_fate: bool,
    /// Whether there is a rate limit, whose queue may delay it more or drop it.
    pub queued: bool,
}

impl Expected {
    fn at(timeline: &mut Timeline, way: Way, t_ns: u64) -> Self {
        let now = timeline.state_at(way, t_ns);
        let soon = timeline.state_at(way, t_ns.saturating_add(EDGE_NS));
        let transmission_ns = |rate_bps: Option<u64>| {
            rate_bps.map_or(0, |rate| {
                u64::from(PACKET_BYTES) * 8 * 1_000_000_000 / rate.max(1)
            })
        };
        let delay_ns = now.delay_ns + transmission_ns(now.rate_bps);
        let soon_ns = soon.delay_ns + transmission_ns(soon.rate_bps);
        Self {
            delay_ns,
            // Where packets wait in order for something, their delay falls by a second each
            // second. That is no step.
            delay_after_step_ns: (delay_ns.abs_diff(soon_ns) > EDGE_NS).then_some(soon_ns),
            lost: now.lost,
            either_fate: now.lost != soon.lost,
            queued: now.rate_bps.or(soon.rate_bps).is_some(),
        }
    }

    /// How much longer than expected a delay was, in ms, against the nearer of the two if a
    /// step was about to come.
    pub(crate) fn excess_ms(&self, measured_ms: f64) -> f64 {
        let excess = measured_ms - ms(self.delay_ns);
        match self.delay_after_step_ns {
            Some(after) if (measured_ms - ms(after)).abs() < excess.abs() => {
                measured_ms - ms(after)
            }
            _ => excess,
        }
    }
}

/// What an echo should have met on both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prediction {
    /// From the controller, entering when it was sent.
    pub up: Expected,
    /// From the plant, entering when it reached that or, if it did not, should have.
    pub down: Expected,
}

impl Prediction {
    /// The round trip time; `None` if the echo was to be lost.
    #[must_use]
    pub fn rtt_ns(&self) -> Option<u64> {
        (!self.up.lost && !self.down.lost)
            .then(|| self.up.delay_ns.saturating_add(self.down.delay_ns))
    }
}

/// Predicts each of the echoes, in their order.
#[must_use]
pub fn predict(echoes: &[Echo], timeline: &mut Timeline) -> Vec<Prediction> {
    let up: Vec<Expected> = echoes
        .iter()
        .map(|echo| Expected::at(timeline, Way::Up, echo.t_send_ns))
        .collect();
    let entry_ns = |(echo, up): (&Echo, &Expected)| {
        echo.t_reach_ns
            .unwrap_or(echo.t_send_ns.saturating_add(up.delay_ns))
    };
    // Paths are asked in order of time and remember only so much, but a link that keeps no
    // order lets echoes reach the plant in another order than they were sent in.
    let mut entries: Vec<(u64, usize)> = echoes.iter().zip(&up).map(entry_ns).zip(0..).collect();
    entries.sort_unstable();
    let mut down: Vec<(usize, Expected)> = entries
        .into_iter()
        .map(|(t_ns, index)| (index, Expected::at(timeline, Way::Down, t_ns)))
        .collect();
    down.sort_unstable_by_key(|&(index, _)| index);
    up.into_iter()
        .zip(down)
        .map(|(up, (_, down))| Prediction { up, down })
        .collect()
}

/// What it costs to cross a player that has nothing to add: measured on the empty link and
/// taken off all residuals, since it is this machine's and not the link's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Baseline {
    /// From controller to plant, ms.
    pub up_ms: f64,
    /// From plant to controller, ms.
    pub down_ms: f64,
    /// The round trip, ms.
    pub rtt_ms: f64,
}

impl Baseline {
    /// Medians over echoes through the empty link; `None` if none came back.
    ///
    /// Where there is no player, as on loopback, there is nothing to take off:
    /// [`Baseline::default`].
    #[must_use]
    pub fn of(echoes: &[Echo]) -> Option<Self> {
        // With an epoch that never comes the timeline is the empty link throughout.
        let mut empty = Timeline::new(&link::Profile::empty(), 0, u64::MAX);
        let excesses: Vec<[f64; 3]> = echoes
            .iter()
            .zip(predict(echoes, &mut empty))
            .filter_map(|(echo, prediction)| excesses_ms(echo, &prediction))
            .collect();
        let middle = |which: usize| median(excesses.iter().map(|excess| excess[which]).collect());
        (!excesses.is_empty()).then(|| Self {
            up_ms: middle(0),
            down_ms: middle(1),
            rtt_ms: middle(2),
        })
    }
}

/// How much longer than predicted the way up, the way down and the round trip of an echo
/// were, ms; `None` if it was not answered.
pub(crate) fn excesses_ms(echo: &Echo, prediction: &Prediction) -> Option<[f64; 3]> {
    let (reach, back) = (echo.t_reach_ns?, echo.t_back_ns?);
    let up = prediction
        .up
        .excess_ms(ms(reach.saturating_sub(echo.t_send_ns)));
    let down = prediction.down.excess_ms(ms(back.saturating_sub(reach)));
    Some([up, down, up + down])
}
