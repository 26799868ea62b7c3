//! When a link counts as the one that was asked for: the limits, each with its reason.
//!
//! On a quiet machine half of the round trips lie within 0.1 ms of their prediction and 99 %
//! within 1 ms. The limits are wider: they have to tell a link that is missing, or another
//! one, from the right one on a machine that is busy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fate::{Doubtful, Fates};
use crate::prediction::{Baseline, Edge};

/// Fewer answers than these can neither prove nor refute a tail of one in fifty.
pub const ANSWERS_NEEDED: usize = 20;

/// Half of the round trips must lie this close to their prediction. It is five times what a
/// quiet machine gives, and less than half of the shortest round trip in the paper, so no
/// link at all is not taken for a short one.
const MEDIAN_LIMIT_MS: f64 = 0.5;

/// Predicting each echo must beat predicting the same for all: the median residual must be
/// at most this share of the median distance of the predictions from their own median.
/// Against a link of the same law and another seed it would be about 1.4, which is the
/// spread of a difference of two independent draws.
const UNEXPLAINED_LIMIT: f64 = 0.7;

/// That comparison is left out where the predictions' median distance is less than this, a
/// link as good as constant.
const SPREAD_NEEDED_MS: f64 = 0.1;

/// A round trip this far from its prediction, and a tenth of the prediction on top, is astray.
/// A processor that is taken away from the player for a time slice or two gives less than the
/// first. The second is for the end of a stall: what it lets go at that instant takes its time
/// to send, 20 ms for the 6700 packets of a client that sent at 1 kHz for 1.3 s. A stall that
/// came at another time is off by all of its length.
const ASTRAY_MS: f64 = 10.0;

/// The share of a round trip that is added to [`ASTRAY_MS`].
const ASTRAY_SHARE: f64 = 0.1;

/// Whether a round trip that misses its prediction by so much is astray.
pub(crate) fn is_astray(miss_ms: f64, predicted_ms: f64) -> bool {
    miss_ms > ASTRAY_MS + ASTRAY_SHARE * predicted_ms
}

/// An echo is quicker than the link only by more than this: the edges of its states are known to less.
const QUICKER_MS: f64 = 0.5;

/// Whether a way that took so much longer than predicted, less if negative, was quicker than the link.
pub(crate) fn is_quicker(residual_ms: f64) -> bool {
    residual_ms < -QUICKER_MS
}

/// At most one echo in so many may be quicker than the link, or have come though it was to be lost,
/// and one on top, before another link is the only explanation.
const ECHOES_PER_IMPOSSIBLE: usize = 100;

/// Whether so many impossible echoes are more than a little error of a clock.
pub(crate) fn are_too_many(impossible: usize, sent: usize) -> bool {
    impossible > 1 + sent / ECHOES_PER_IMPOSSIBLE
}

/// How many echoes may be quicker than the link. Where it is played in changes, those that come later
/// than the edge says let an older state act for longer: on a quiet machine one in a hundred, and an echo
/// crosses two ways; in an emulated kernel on one core, where this was one to five echoes in a hundred,
/// more. Around a link go all of them, and by another seed's half.
pub(crate) fn most_quicker(sent: usize, edge: Edge) -> usize {
    let share = match edge.before_ns {
        0 => 1,
        _ => 10,
    };
    1 + share * sent / ECHOES_PER_IMPOSSIBLE
}

/// What the empty link costs each way, at most: an interrupt, a wake and a copy or two on a machine
/// that is slow. More is a delay that somebody else adds, and would be taken off what is measured.
const BASELINE_LIMIT_MS: f64 = 1.5;

/// At most this share of the echoes may be astray. A link whose stalls come at other times
/// leads more of them astray than that.
const ASTRAY_LIMIT: f64 = 0.02;

/// At most one echo in so many may have a fate other than predicted, rounded down: none in
/// the first 499. It takes an interruption at the wrong microsecond on top of a change of
/// the link's state.
const ECHOES_PER_WRONG_FATE: usize = 500;

/// Losses that were due and losses that were found, near changes of the link's state, may
/// differ by so many standard deviations of their sum, and by one. That is a false alarm in
/// some hundreds of runs, and eleven losses of which none came about are found out.
const LOSS_DEVIATIONS: f64 = 3.0;

/// Whether the link was the one that was asked for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The link was the one asked for.
    Holds,
    /// The link was another, or there were too few answers to judge it, for these reasons.
    Broken(Vec<String>),
}

/// All that the verdict rests on.
pub(crate) struct Evidence {
    /// Echoes sent.
    pub(crate) sent: usize,
    /// Echoes answered.
    pub(crate) answered: usize,
    /// Whether delays could be predicted, and not only their least values.
    pub(crate) exact: bool,
    /// Answered echoes that were quicker than the link.
    pub(crate) quicker: usize,
    /// How many of them there may be.
    pub(crate) most_quicker: usize,
    /// What the empty link costs.
    pub(crate) baseline: Baseline,
    /// Median distance of a round trip from its prediction.
    pub(crate) median_ms: f64,
    /// Median distance of the predictions from their own median.
    pub(crate) spread_ms: f64,
    /// Share of round trips that are astray.
    pub(crate) astray: f64,
    /// Fates other than predicted.
    pub(crate) fates: Fates,
    /// Losses near changes.
    pub(crate) doubtful: Doubtful,
}

impl Evidence {
    pub(crate) fn judge(&self) -> Verdict {
        let mut reasons = Vec::new();
        let cost_ms = self.baseline.up_ms.max(self.baseline.down_ms);
        if cost_ms > BASELINE_LIMIT_MS {
            reasons.push(format!(
                "the empty link costs {cost_ms:.3} ms in one direction (limit {BASELINE_LIMIT_MS} \
                 ms): something delays all packets"
            ));
        }
        if self.quicker > self.most_quicker {
            reasons.push(format!(
                "{} of {} echoes were quicker than the link allows by more than {QUICKER_MS} ms \
                 (limit {})",
                self.quicker, self.sent, self.most_quicker
            ));
        }
        let wrong_fates = self.sent / ECHOES_PER_WRONG_FATE;
        if self.fates.came_though_lost > wrong_fates {
            reasons.push(format!(
                "{} of {} echoes crossed the link when it should have lost them (limit \
                 {wrong_fates})",
                self.fates.came_though_lost, self.sent
            ));
        }
        // A full queue is no fault of the link.
        if self.exact && self.fates.lost_though_due > wrong_fates {
            reasons.push(format!(
                "{} of {} echoes were lost when the link should have carried them (limit \
                 {wrong_fates})",
                self.fates.lost_though_due, self.sent
            ));
        }
        let Doubtful { due, lost } = self.doubtful;
        let deviation = ((due + lost) as f64).sqrt();
        // A full queue is no fault of the link.
        let counts = self.exact || lost < due;
        if counts && due.abs_diff(lost) as f64 > 1.0 + LOSS_DEVIATIONS * deviation {
            reasons.push(format!(
                "{lost} echoes were lost near changes of the link, where it should have lost {due}"
            ));
        }
        if self.answered < ANSWERS_NEEDED {
            reasons.push(format!(
                "only {} of {} echoes were answered; {ANSWERS_NEEDED} are needed to judge the link",
                self.answered, self.sent
            ));
            return Verdict::Broken(reasons);
        }
        if self.median_ms > MEDIAN_LIMIT_MS {
            reasons.push(format!(
                "half of the round trips are {:.3} ms or more from their prediction (limit {MEDIAN_LIMIT_MS} ms)",
                self.median_ms
            ));
        }
        if self.spread_ms >= SPREAD_NEEDED_MS && self.median_ms > UNEXPLAINED_LIMIT * self.spread_ms
        {
            reasons.push(format!(
                "the round trips do not follow their prediction: they lie {:.3} ms from it, and it \
                 varies by only {:.3} ms",
                self.median_ms, self.spread_ms
            ));
        }
        if self.astray > ASTRAY_LIMIT {
            reasons.push(format!(
                "{:.1} % of the round trips miss their prediction by more than {ASTRAY_MS} ms plus \
                 a tenth (limit {} %)",
                100.0 * self.astray,
                100.0 * ASTRAY_LIMIT
            ));
        }
        if reasons.is_empty() {
            Verdict::Holds
        } else {
            Verdict::Broken(reasons)
        }
    }
}
