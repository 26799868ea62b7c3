//! Decides whether a link was the one asked for: compares each echo that crossed it with its prediction.
//!
//! Pure functions. The limits behind the [verdict](crate::certificate::Verdict) are in a file of their own.

use crate::profile::Profile;
use crate::time::Epoch;
use crate::timeline::Timeline;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::echo::Echo;
use crate::certificate::entry::Entries;
use crate::certificate::fate::{Fates, fates};
use crate::certificate::prediction::{Baseline, Edge, Prediction, excesses_ms, predict_within};
use crate::certificate::statistics::{RttStatistics, median, ms, quantile, spread_ms};
use crate::certificate::verdict::{Evidence, Verdict, are_too_many, is_astray, most_quicker};

/// How far residuals lie from zero on one way or over the round trip: measured minus
/// predicted minus baseline, ms. The quantiles are of absolute values.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Residual {
    /// The mean with its sign.
    pub bias_ms: f64,
    /// Half of them are at most this.
    pub median_ms: f64,
    /// Nine of ten are at most this.
    pub p90_ms: f64,
    /// 99 of 100 are at most this.
    pub p99_ms: f64,
    /// The greatest residual, in ms.
    pub max_ms: f64,
}

impl Residual {
    fn of(residuals_ms: impl Iterator<Item = f64> + Clone) -> Self {
        let mut sizes: Vec<f64> = residuals_ms.clone().map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        Self {
            bias_ms: residuals_ms.sum::<f64>() / sizes.len().max(1) as f64,
            median_ms: quantile(&sizes, 0.5),
            p90_ms: quantile(&sizes, 0.9),
            p99_ms: quantile(&sizes, 0.99),
            max_ms: quantile(&sizes, 1.0),
        }
    }
}

/// Residuals of the answered echoes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Residuals {
    /// From controller to plant.
    pub up: Residual,
    /// From plant to controller.
    pub down: Residual,
    /// The round trip.
    pub rtt: Residual,
}

impl Residuals {
    fn of(echoes: &[AnsweredEcho]) -> Self {
        let way =
            |which: usize| Residual::of(echoes.iter().map(move |echo| echo.residuals_ms[which]));
        Self {
            up: way(0),
            down: way(1),
            rtt: way(2),
        }
    }
}

/// The proof that a link was the one that was asked for, or the evidence that it was not.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Whether the link held, and why not.
    pub verdict: Verdict,
    /// Echoes sent.
    pub sent: usize,
    /// Echoes answered.
    pub answered: usize,
    /// Whether each delay could be predicted. With a rate limit only its least value can:
    /// the queue depends on other traffic.
    pub exact: bool,
    /// The cost of the empty link, which residuals are free of.
    pub baseline: Baseline,
    /// How far measured and predicted times lie apart.
    pub residuals: Residuals,
    /// The share of answered echoes whose round trip is astray.
    pub astray: f64,
    /// Answered echoes that were quicker than the link lets them, on a way.
    #[serde(default)]
    pub quicker: usize,
    /// How many of them there may be, before another link is the only explanation.
    #[serde(default)]
    pub most_quicker: usize,
    /// Echoes whose fate was not the predicted one.
    pub fates: Fates,
    /// Round trips as the link was to make them, at the instants of these echoes.
    pub predicted: RttStatistics,
    /// Round trips as they were, baseline included.
    pub measured: RttStatistics,
}

impl Certificate {
    /// Whether there is evidence of another link that a pause of the machine cannot explain: echoes that were
    /// quicker than the link, or that it should have lost. A machine can only delay or lose echoes.
    #[must_use]
    pub fn is_another(&self) -> bool {
        self.quicker > self.most_quicker || are_too_many(self.fates.came_though_lost, self.sent)
    }
}

/// Compares echoes with the link of `profile` and `seed` that begins at `epoch`, played in user space.
#[must_use]
pub fn certify(
    echoes: &[Echo],
    profile: &Profile,
    seed: u64,
    epoch: Epoch,
    baseline: Baseline,
) -> Certificate {
    let timeline = Timeline::new(profile, seed, epoch);
    certify_within(echoes, timeline, baseline, Edge::USER)
}

/// What an answered echo says of the link.
struct AnsweredEcho {
    /// Up, down and over the round trip.
    residuals_ms: [f64; 3],
    /// The predicted delay of its round trip.
    due_ms: f64,
    /// How far its round trip misses that.
    miss_ms: f64,
}

/// Whether each delay could be predicted, and not only its least value.
fn is_exact(predictions: &[Prediction]) -> bool {
    !predictions
        .iter()
        .any(|prediction| prediction.up.queued || prediction.down.queued)
}

/// All answered echoes beside their predictions.
fn answered(echoes: &[Echo], predictions: &[Prediction], baseline: Baseline) -> Vec<AnsweredEcho> {
    // Where a queue may add to the delay, only an early packet is evidence against the link.
    let exact = is_exact(predictions);
    let pairs = echoes.iter().zip(predictions);
    pairs
        .filter_map(|(echo, prediction)| {
            let [up, down, rtt] = excesses_ms(echo, prediction)?;
            let late_ms = rtt - baseline.rtt_ms;
            // The empty link cost something between nothing and its median: it may have been measured in a busy
            // moment, and an echo of a quiet one is no sooner than its link for it.
            let early_ms = -(late_ms + baseline.rtt_ms.max(0.0));
            let wrong_ms = if exact { late_ms } else { 0.0 };
            Some(AnsweredEcho {
                residuals_ms: [up - baseline.up_ms, down - baseline.down_ms, late_ms],
                due_ms: ms(prediction.up.delay_ns + prediction.down.delay_ns),
                miss_ms: wrong_ms.max(early_ms).max(0.0),
            })
        })
        .collect()
}

/// Compares echoes with the link that they should have met; `edge` says how exactly its player keeps
/// the times of the link's states.
#[must_use]
pub fn certify_within(
    echoes: &[Echo],
    mut timeline: Timeline,
    baseline: Baseline,
    edge: Edge,
) -> Certificate {
    // Asked again below: a timeline forgets what lies far behind its newest query.
    let link = timeline.clone();
    let predictions = predict_within(echoes, &mut timeline, edge);
    let exact = is_exact(&predictions);
    let answered = answered(echoes, &predictions, baseline);
    let astray = answered
        .iter()
        .filter(|echo| is_astray(echo.miss_ms, echo.due_ms))
        .count();
    let entries = Entries::of(&link);
    let pairs = echoes.iter().zip(&predictions);
    let quicker = pairs
        .filter(|(echo, prediction)| entries.is_quicker(echo, prediction))
        .count();
    let (fates, doubtful) = fates(echoes, &predictions, &entries);
    let predicted_ms: Vec<f64> = predictions
        .iter()
        .filter_map(|prediction| prediction.rtt_ns().map(ms))
        .collect();
    let measured_ms: Vec<f64> = echoes
        .iter()
        .filter_map(|echo| echo.rtt_ns().map(ms))
        .collect();
    let evidence = Evidence {
        sent: echoes.len(),
        answered: answered.len(),
        exact,
        quicker,
        most_quicker: most_quicker(echoes.len(), edge),
        baseline,
        median_ms: median(answered.iter().map(|echo| echo.miss_ms).collect()),
        spread_ms: spread_ms(&predicted_ms),
        astray,
        fates,
        doubtful,
    };
    Certificate {
        verdict: evidence.judge(),
        sent: echoes.len(),
        answered: measured_ms.len(),
        exact,
        baseline,
        residuals: Residuals::of(&answered),
        astray: astray as f64 / answered.len().max(1) as f64,
        quicker,
        most_quicker: most_quicker(echoes.len(), edge),
        fates,
        predicted: RttStatistics::of(echoes.len(), &predicted_ms),
        measured: RttStatistics::of(echoes.len(), &measured_ms),
    }
}
