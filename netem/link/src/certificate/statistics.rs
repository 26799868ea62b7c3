//! The few statistics that `ping` prints, and quantiles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Round trips as `ping` sums them up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RttStatistics {
    /// The least, ms.
    pub min_ms: f64,
    /// The mean, ms.
    pub avg_ms: f64,
    /// The greatest, ms.
    pub max_ms: f64,
    /// The standard deviation, ms: of these very round trips, dividing by their number as
    /// `ping` does for its mdev.
    pub sd_ms: f64,
    /// The share of echoes that were not answered, 0 to 1.
    pub loss: f64,
}

impl RttStatistics {
    /// The least, the mean, the greatest and the standard deviation, ms; `None` if no echo was answered.
    #[must_use]
    pub fn times_ms(&self) -> Option<[f64; 4]> {
        // A round trip takes its time, so the greatest is 0 only where there was none.
        (self.max_ms > 0.0).then_some([self.min_ms, self.avg_ms, self.max_ms, self.sd_ms])
    }

    /// Statistics of `sent` echoes and the round trips of the answered ones. The times are 0 if none
    /// was answered.
    #[must_use]
    pub fn of(sent: usize, rtts_ms: &[f64]) -> Self {
        if rtts_ms.is_empty() {
            return Self {
                loss: if sent == 0 { 0.0 } else { 1.0 },
                ..Self::default()
            };
        }
        let n = rtts_ms.len() as f64;
        let avg_ms = rtts_ms.iter().sum::<f64>() / n;
        let variance = rtts_ms
            .iter()
            .map(|rtt| (rtt - avg_ms).powi(2))
            .sum::<f64>()
            / n;
        Self {
            min_ms: rtts_ms.iter().copied().fold(f64::INFINITY, f64::min),
            avg_ms,
            max_ms: rtts_ms.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            sd_ms: variance.sqrt(),
            loss: 1.0 - n / sent as f64,
        }
    }
}

/// The least value that at least a share `q` of the values do not exceed; 0 without values.
pub(crate) fn quantile(sorted: &[f64], q: f64) -> f64 {
    let rank = (q * sorted.len() as f64).ceil().max(1.0) as usize;
    sorted.get(rank - 1).copied().unwrap_or(0.0)
}

/// The median; 0 without values.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.5)
}

/// The median distance of values from their median.
pub(crate) fn spread_ms(values_ms: &[f64]) -> f64 {
    let middle = median(values_ms.to_vec());
    median(
        values_ms
            .iter()
            .map(|value| (value - middle).abs())
            .collect(),
    )
}

/// Nanoseconds as milliseconds.
pub(crate) fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_round_trips_of_four_echoes_by_hand() {
        // The mean of 1 and 3 is 2, each lies 1 from it, and half were lost.
        assert_eq!(
            RttStatistics::of(4, &[1.0, 3.0]),
            RttStatistics {
                min_ms: 1.0,
                avg_ms: 2.0,
                max_ms: 3.0,
                sd_ms: 1.0,
                loss: 0.5
            }
        );
    }

    #[test]
    fn no_answer_at_all_is_a_loss_of_one() {
        assert_eq!(RttStatistics::of(3, &[]).loss, 1.0);
        assert_eq!(RttStatistics::of(0, &[]).loss, 0.0);
        assert_eq!(RttStatistics::of(3, &[]).times_ms(), None);
        assert_eq!(
            RttStatistics::of(3, &[2.0]).times_ms(),
            Some([2.0, 2.0, 2.0, 0.0])
        );
    }

    #[test]
    fn quantiles_by_hand() {
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(quantile(&sorted, 0.5), 50.0);
        assert_eq!(quantile(&sorted, 0.99), 99.0);
        assert_eq!(quantile(&sorted, 1.0), 100.0);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
