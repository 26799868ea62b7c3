//! What each echo of a probe should have met: the timeline of the same profile and seed at the
//! instants when the echo entered the link.
//!
//! Pure functions. The queue in front of a rate limit depends on other traffic. It is predicted if
//! the player recorded what entered; otherwise the prediction is the least possible delay.

use crate::timeline::Timeline;
use crate::way::Way;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::echo::{Echo, PACKET_BYTES};
use crate::certificate::statistics::{median, ms};

/// How far the instant at which a packet meets the link's state may differ from the instant known of
/// it. A packet this close to a change may have met the state before or after the change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// How long a state may still act after its end.
    pub before_ns: u64,
    /// How early a coming state may act.
    pub after_ns: u64,
    /// How far a falling delay may be off, if it is followed in steps.
    pub fall_ns: u64,
}

impl Edge {
    /// The player in user space. A packet enters the link a few microseconds after the instant known
    /// of it, at which it was handed to the kernel or reached the plant that answers. The player
    /// decides by the packet's stamp and is never late.
    pub const USER: Edge = Edge {
        before_ns: 0,
        after_ns: 200_000,
        fall_ns: 0,
    };

    /// The tc player, whose changes act only once they have been carried out. How late they were
    /// makes the edge wider; see [`TcReport::edge`](crate::certificate::TcReport::edge).
    pub const TC: Edge = Edge {
        before_ns: crate::staircase::STEP_NS,
        after_ns: Edge::USER.after_ns,
        fall_ns: crate::staircase::STEP_NS / 2,
    };

    /// The wider of two edges on each side.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            before_ns: self.before_ns.max(other.before_ns),
            after_ns: self.after_ns.max(other.after_ns),
            fall_ns: self.fall_ns.max(other.fall_ns),
        }
    }
}

/// The states within an edge are sampled at this interval. It divides the millisecond in which loss
/// is decided.
pub(crate) const LOOK_NS: u64 = 200_000;

/// What a packet should meet on one way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Its delay, ns.
    pub delay_ns: u64,
    /// Other delays that are possible: those before or after a nearby step of the delay, or half a
    /// step from a falling one.
    pub delays_beside_ns: Vec<u64>,
    /// Whether it is lost.
    pub lost: bool,
    /// Whether its loss changes nearby, so that either fate agrees with the prediction.
    pub either_fate: bool,
    /// Whether there is a queue of unknown length, which may delay it more, or drop it.
    pub queued: bool,
}

impl Expected {
    fn at(timeline: &mut Timeline, way: Way, t_ns: u64, edge: Edge) -> Self {
        let now = timeline.passage(way, t_ns, PACKET_BYTES);
        let mut expected = Self {
            delay_ns: now.delay_ns,
            delays_beside_ns: Vec::new(),
            lost: now.lost,
            either_fate: false,
            queued: now.queued,
        };
        let mut falls = false;
        let before = (1..=edge.before_ns / LOOK_NS).map(|look| t_ns.saturating_sub(look * LOOK_NS));
        let after = (1..=edge.after_ns / LOOK_NS).map(|look| t_ns.saturating_add(look * LOOK_NS));
        for beside_ns in before.chain(after) {
            let beside = timeline.passage(way, beside_ns, PACKET_BYTES);
            let delay_ns = beside.delay_ns;
            // While packets wait in order, their delay falls by one second per second. That is no step.
            match delay_ns.abs_diff(expected.delay_ns) {
                0 => {}
                apart_ns if apart_ns > beside_ns.abs_diff(t_ns) => {
                    expected.delays_beside_ns.push(delay_ns);
                }
                _ => falls = true,
            }
            expected.either_fate |= beside.lost != now.lost;
            expected.queued |= beside.queued;
        }
        if falls && edge.fall_ns > 0 {
            let due_ns = expected.delay_ns;
            let beside = [due_ns.saturating_sub(edge.fall_ns), due_ns + edge.fall_ns];
            expected.delays_beside_ns.extend(beside);
        }
        expected
    }

    /// How much longer than expected a delay was, in ms, compared with the nearest of the possible delays.
    pub(crate) fn excess_ms(&self, measured_ms: f64) -> f64 {
        let excess_ms = |due_ns: &u64| measured_ms - ms(*due_ns);
        let nearer = |nearest: f64, excess: f64| {
            if excess.abs() < nearest.abs() {
                excess
            } else {
                nearest
            }
        };
        let beside = self.delays_beside_ns.iter().map(excess_ms);
        beside.fold(excess_ms(&self.delay_ns), nearer)
    }
}

/// What an echo should have met on both ways.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prediction {
    /// From the controller; it enters when it was sent.
    pub up: Expected,
    /// From the plant; it enters when it reached the plant or, if it did not, should have.
    pub down: Expected,
}

impl Prediction {
    /// The round-trip time; `None` if the echo should be lost.
    #[must_use]
    pub fn rtt_ns(&self) -> Option<u64> {
        (!self.up.lost && !self.down.lost)
            .then(|| self.up.delay_ns.saturating_add(self.down.delay_ns))
    }
}

/// Predicts each echo, in order, for the player in user space.
#[must_use]
pub fn predict(echoes: &[Echo], timeline: &mut Timeline) -> Vec<Prediction> {
    predict_within(echoes, timeline, Edge::USER)
}

/// Predicts each echo, in order.
#[must_use]
pub fn predict_within(echoes: &[Echo], timeline: &mut Timeline, edge: Edge) -> Vec<Prediction> {
    let up: Vec<Expected> = echoes
        .iter()
        .map(|echo| Expected::at(timeline, Way::Up, echo.t_send_ns, edge))
        .collect();
    let entry_ns = |(echo, up): (&Echo, &Expected)| {
        echo.t_reach_ns
            .unwrap_or(echo.t_send_ns.saturating_add(up.delay_ns))
    };
    // Paths must be asked in order of time, since they remember only so much; but if a link does not
    // keep the order, echoes reach the plant in another order than they were sent.
    let mut entries: Vec<(u64, usize)> = echoes.iter().zip(&up).map(entry_ns).zip(0..).collect();
    entries.sort_unstable();
    let mut down: Vec<(usize, Expected)> = entries
        .into_iter()
        .map(|(t_ns, index)| (index, Expected::at(timeline, Way::Down, t_ns, edge)))
        .collect();
    down.sort_unstable_by_key(|&(index, _)| index);
    up.into_iter()
        .zip(down)
        .map(|(up, (_, down))| Prediction { up, down })
        .collect()
}

/// What it costs to cross a player that has nothing to add: measured on the empty link and
/// taken off all residuals, since it is this machine's and not the link's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
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
    /// Without a player, as on loopback, there is nothing to subtract: [`Baseline::default`].
    #[must_use]
    pub fn of(echoes: &[Echo]) -> Option<Self> {
        // With an epoch that never comes the timeline stays the empty link.
        let mut empty = Timeline::new(
            &crate::profile::Profile::empty(),
            0,
            crate::time::Epoch::at_ns(u64::MAX),
        );
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

/// How much longer than predicted an echo's way up, way down and round trip were, ms; `None` if it
/// was not answered.
pub(crate) fn excesses_ms(echo: &Echo, prediction: &Prediction) -> Option<[f64; 3]> {
    let (reach, back) = (echo.t_reach_ns?, echo.t_back_ns?);
    let up = prediction
        .up
        .excess_ms(ms(reach.saturating_sub(echo.t_send_ns)));
    let down = prediction.down.excess_ms(ms(back.saturating_sub(reach)));
    Some([up, down, up + down])
}
