//! When a link counts as the one asked for: the limits, each with its reason.
//!
//! On a quiet machine half of the round trips lie within 0.1 ms of their prediction and 99 % within 1
//! ms. The limits are wider: on a busy machine, too, they have to tell the right link from a missing
//! or another one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::entry::QUICKER_NS;
use crate::certificate::fate::{Doubtful, Fates};
use crate::certificate::prediction::{Baseline, Edge};
use crate::certificate::statistics::ms;

/// Fewer answers than this can neither prove nor refute a tail of one in fifty.
pub const ANSWERS_NEEDED: usize = 20;

/// Half of the round trips must lie this close to their prediction. It is five times the value of a
/// quiet machine, and less than half of the shortest round trip in the paper, so that a missing link
/// does not pass for a short one.
const MEDIAN_LIMIT_MS: f64 = 0.5;

/// Predicting each echo must be better than predicting the same for all: the median residual must be
/// at most this share of the median distance of the predictions from their own median. For a link of
/// the same law and another seed the ratio would be about 1.4, the spread of a difference of two
/// independent draws.
const UNEXPLAINED_LIMIT: f64 = 0.7;

/// That comparison is left out if the predictions' median distance is less than this, because the
/// link is almost constant.
const SPREAD_NEEDED_MS: f64 = 0.1;

/// A round trip is astray if it misses its prediction by more than this plus a tenth of the
/// prediction. A player that loses its processor for a time slice or two causes less than the first
/// part. The second part is for the end of a stall: the packets that it releases at once take time to
/// send, 20 ms for the 6700 packets of a client that sent at 1 kHz for 1.3 s. A stall that comes at
/// another time is off by its whole length.
const ASTRAY_MS: f64 = 10.0;

/// The share of a round trip that is added to [`ASTRAY_MS`].
const ASTRAY_SHARE: f64 = 0.1;

/// Whether a round trip that misses its prediction by `miss_ms` is astray.
pub(crate) fn is_astray(miss_ms: f64, predicted_ms: f64) -> bool {
    miss_ms > ASTRAY_MS + ASTRAY_SHARE * predicted_ms
}

/// One echo in this many, plus one, may be quicker than the link or have come although it should have
/// been lost. With more, another link is the only explanation.
const ECHOES_PER_IMPOSSIBLE: usize = 100;

/// Whether this many impossible echoes are more than a small clock error explains.
pub(crate) fn are_too_many(impossible: usize, sent: usize) -> bool {
    impossible > 1 + sent / ECHOES_PER_IMPOSSIBLE
}

/// How many echoes may be quicker than the link. If the link is played in changes (tc), a change that
/// is later than the edge lets the older state act for longer. On a quiet machine this is one change
/// in a hundred, and an echo crosses two ways; in an emulated kernel on one core it is more, and one
/// to five echoes in a hundred were quicker. If the traffic bypasses the link, all echoes are
/// quicker; with another seed, half of them.
pub(crate) fn most_quicker(sent: usize, edge: Edge) -> usize {
    let share = match edge.before_ns {
        0 => 1,
        _ => 10,
    };
    1 + share * sent / ECHOES_PER_IMPOSSIBLE
}

/// Most that the empty link may cost each way: an interrupt, a wake-up and a copy or two on a slow
/// machine. More than that is a delay that something else adds, which would be subtracted from the
/// measurement.
const BASELINE_LIMIT_MS: f64 = 1.5;

/// At most this share of the answered echoes may be astray, plus one, so that no share is judged from a
/// single echo. A link whose stalls come at other times makes more of them astray.
const ASTRAY_LIMIT: f64 = 0.02;

/// How many of the answered echoes may be astray.
fn most_astray(answered: usize) -> usize {
    1 + (ASTRAY_LIMIT * answered as f64) as usize
}

/// At most one echo in this many may have a fate other than predicted, rounded down: none in the
/// first 499. Such an echo takes an interruption at the wrong microsecond as well as a change of the
/// link's state.
const ECHOES_PER_WRONG_FATE: usize = 500;

/// Predicted losses and actual losses near changes of the link's state may differ by this many
/// standard deviations of their sum, plus one. That is one false alarm in some hundreds of runs, and
/// it detects eleven predicted losses of which none happened.
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

/// The evidence for the verdict.
pub(crate) struct Evidence {
    /// Echoes sent.
    pub(crate) sent: usize,
    /// Echoes answered.
    pub(crate) answered: usize,
    /// Whether delays could be predicted exactly, not only their least values.
    pub(crate) exact: bool,
    /// Answered echoes that were quicker than the link.
    pub(crate) quicker: usize,
    /// How many of them are allowed.
    pub(crate) most_quicker: usize,
    /// The cost of the empty link.
    pub(crate) baseline: Baseline,
    /// Median distance of a round trip from its prediction.
    pub(crate) median_ms: f64,
    /// Median distance of the predictions from their own median.
    pub(crate) spread_ms: f64,
    /// Answered echoes whose round trip is astray.
    pub(crate) astray: usize,
    /// Echoes with a fate other than predicted.
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
                "{} of {} echoes were quicker than the link allows by more than {} ms \
                 (limit {})",
                self.quicker,
                self.sent,
                ms(QUICKER_NS),
                self.most_quicker
            ));
        }
        self.judge_fates(&mut reasons);
        if self.answered < ANSWERS_NEEDED {
            reasons.push(format!(
                "only {} of {} echoes were answered; {ANSWERS_NEEDED} are needed to judge the link",
                self.answered, self.sent
            ));
            return Verdict::Broken(reasons);
        }
        self.judge_round_trips(&mut reasons);
        if reasons.is_empty() {
            Verdict::Holds
        } else {
            Verdict::Broken(reasons)
        }
    }

    /// Whether echoes were lost, and came, as the link does it.
    fn judge_fates(&self, reasons: &mut Vec<String>) {
        let wrong_fates = self.sent / ECHOES_PER_WRONG_FATE;
        if self.fates.came_though_lost > wrong_fates {
            reasons.push(format!(
                "{} of {} echoes crossed the link when it should have lost them (limit \
                 {wrong_fates})",
                self.fates.came_though_lost, self.sent
            ));
        }
        // A full queue is not a fault of the link.
        if self.exact && self.fates.lost_though_due > wrong_fates {
            reasons.push(format!(
                "{} of {} echoes were lost when the link should have carried them (limit \
                 {wrong_fates})",
                self.fates.lost_though_due, self.sent
            ));
        }
        let Doubtful { due, lost } = self.doubtful;
        let deviation = ((due + lost) as f64).sqrt();
        // A full queue is not a fault of the link.
        let counts = self.exact || lost < due;
        if counts && due.abs_diff(lost) as f64 > 1.0 + LOSS_DEVIATIONS * deviation {
            reasons.push(format!(
                "{lost} echoes were lost near changes of the link, where it should have lost {due}"
            ));
        }
    }

    /// Whether answered echoes took the time that the link takes.
    fn judge_round_trips(&self, reasons: &mut Vec<String>) {
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
        let most_astray = most_astray(self.answered);
        if self.astray > most_astray {
            reasons.push(format!(
                "{} of {} round trips miss their prediction by more than {ASTRAY_MS} ms plus a tenth \
                 (limit {most_astray})",
                self.astray, self.answered
            ));
        }
    }
}
