//! Moments and a least-squares line in one pass, and quantiles that are left out if the sample is too
//! small.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

/// Mean and spread of a series, by Welford's recurrence.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moments {
    n: u64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Moments {
    /// Adds a value.
    pub fn push(&mut self, x: f64) {
        (self.min, self.max) = match self.n {
            0 => (x, x),
            _ => (self.min.min(x), self.max.max(x)),
        };
        self.n += 1;
        let off = x - self.mean;
        self.mean += off / self.n as f64;
        self.squares += off * (x - self.mean);
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.n
    }

    /// The four figures that `ping` prints; `None` if there are no values.
    #[must_use]
    pub fn spread(&self) -> Option<Spread> {
        (self.n > 0).then(|| Spread {
            min_ms: self.min,
            avg_ms: self.mean,
            max_ms: self.max,
            sd_ms: (self.squares / self.n as f64).sqrt(),
        })
    }
}

/// min/avg/max/sd in ms. The standard deviation divides by the number of values, as `ping` does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Minimum.
    pub min_ms: f64,
    /// Mean.
    pub avg_ms: f64,
    /// Maximum.
    pub max_ms: f64,
    /// Standard deviation.
    pub sd_ms: f64,
}

/// The mean; not a number if there are no values.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The median of values that may be infinite. `None` if there are none, or if it lies between two
/// opposite infinities.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The quantile `q`, from 0 to 1, of values that may be infinite. Between two values it is their
/// mean, as for a median. `None` in the cases of [`median`].
#[must_use]
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, q)
}

/// The [`quantile`] of values that are in order already.
#[must_use]
pub fn quantile_of_sorted(sorted: &[f64], q: f64) -> Option<f64> {
    let rank = q * sorted.len().checked_sub(1)? as f64;
    let at = |rank: f64| sorted.get(rank as usize).copied();
    let (low, high) = (at(rank.floor())?, at(rank.ceil())?);
    let middle = if low == high {
        low
    } else {
        f64::midpoint(low, high)
    };
    (!middle.is_nan()).then_some(middle)
}

/// The median as a value that was measured: of an even number of values the greater of the two in the middle, where
/// [`median`] is their mean. `None` without values, which it reorders.
pub fn upper_median<T: Copy>(values: &mut [T], order: fn(&T, &T) -> Ordering) -> Option<T> {
    let middle = values.len() / 2;
    at_rank(values, middle, order)
}

/// The same, but of an even number of values the less of the two in the middle.
pub fn lower_median<T: Copy>(values: &mut [T], order: fn(&T, &T) -> Ordering) -> Option<T> {
    let middle = values.len().checked_sub(1)? / 2;
    at_rank(values, middle, order)
}

/// The value that would be at `rank` if they were sorted, in a tenth of the time that sorting takes.
fn at_rank<T: Copy>(values: &mut [T], rank: usize, order: fn(&T, &T) -> Ordering) -> Option<T> {
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, order).1)
}

/// The least-squares line through points, in one pass.
#[derive(Debug, Clone, Copy, Default)]
pub struct Line {
    n: u64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Line {
    /// Adds a point.
    pub fn push(&mut self, x: f64, y: f64) {
        self.n += 1;
        let n = self.n as f64;
        let off = x - self.x;
        self.x += off / n;
        self.y += (y - self.y) / n;
        self.xx += off * (x - self.x);
        self.xy += off * (y - self.y);
    }

    /// The slope; `None` with fewer than two different x.
    #[must_use]
    pub fn slope(&self) -> Option<f64> {
        (self.xx > 0.0).then(|| self.xy / self.xx)
    }
}

/// Quantiles in ms; one with too few samples is `None`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// The median.
    pub p50_ms: Option<f64>,
    /// The 90th percentile.
    pub p90_ms: Option<f64>,
    /// The 99th percentile.
    pub p99_ms: Option<f64>,
    /// The maximum.
    pub max_ms: Option<f64>,
}

/// A quantile needs this many samples beyond it, or one or two samples decide it by luck. So a median
/// needs 10 samples, p90 needs 50, p99 needs 500.
const BEYOND: f64 = 5.0;

impl Quantiles {
    /// Quantiles of values in ns, in any order.
    #[must_use]
    pub fn of(ns: Vec<u64>) -> Self {
        Quantiles::with_missing(ns, 0)
    }

    /// Quantiles of values in ns, in any order, and of `missing` others that are greater than any: messages without an
    /// answer. One that falls among those has no value, as the maximum if there are any.
    #[must_use]
    pub fn with_missing(mut ns: Vec<u64>, missing: u64) -> Self {
        let count = ns
            .len()
            .saturating_add(usize::try_from(missing).unwrap_or(usize::MAX));
        let mut end = ns.len();
        let max_ms = ns.iter().max().copied().filter(|_| missing == 0).map(ms);
        // From the highest quantile down: a selection leaves all values that are not greater on its
        // left.
        let mut quantile_ms = |q| {
            let at = rank(count, q)?;
            let (_, value, _) = ns
                .get_mut(..end)
                .filter(|ns| at < ns.len())?
                .select_nth_unstable(at);
            end = at + 1;
            Some(ms(*value))
        };
        let p99_ms = quantile_ms(0.99);
        let p90_ms = quantile_ms(0.9);
        let p50_ms = quantile_ms(0.5);
        Self {
            p50_ms,
            p90_ms,
            p99_ms,
            max_ms,
        }
    }

    /// Whether the quantile `q` of so many values falls among the missing ones, which are greater than any.
    #[must_use]
    pub fn falls_among_missing(q: f64, there: u64, missing: u64) -> bool {
        let whole = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
        let at = rank(whole(there.saturating_add(missing)), q);
        at.is_some_and(|at| at >= whole(there))
    }
}

/// Index, among `count` sorted values, of the least one that a share `q` of them do not exceed;
/// `None` if there are too few: fewer than five beyond it.
#[must_use]
pub fn rank(count: usize, q: f64) -> Option<usize> {
    let n = count as f64;
    // 1 - q is not exact: 500 * (1 - 0.99) may be slightly below 5.
    if n * (1.0 - q) < BEYOND - 1e-9 {
        return None;
    }
    Some((q * n - 1e-9).ceil().max(1.0) as usize - 1)
}

/// The value that a share `q` of sorted values do not exceed; `None` if they are too few for it, by the rule of
/// [`rank`].
#[must_use]
pub fn percentile(sorted: &[f64], q: f64) -> Option<f64> {
    sorted.get(rank(sorted.len(), q)?).copied()
}

/// `part` divided by `whole`; `None` if `whole` is 0.
#[must_use]
pub fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// Converts nanoseconds to milliseconds.
#[must_use]
pub fn ms(ns: u64) -> f64 {
    ns as f64 / 1e6
}

/// `to - from` in milliseconds; negative if `to` is earlier.
#[must_use]
pub fn ms_between(from_ns: u64, to_ns: u64) -> f64 {
    if to_ns >= from_ns {
        ms(to_ns - from_ns)
    } else {
        -ms(from_ns - to_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;

    #[test]
    fn quantiles_by_hand_and_none_where_luck_would_decide() {
        let ns: Vec<u64> = (1..=500).map(|i| i * 1_000_000).rev().collect();
        let all = Quantiles::of(ns.clone());
        assert_eq!((all.p50_ms, all.p90_ms), (Some(250.0), Some(450.0)));
        assert_eq!((all.p99_ms, all.max_ms), (Some(495.0), Some(500.0)));
        let fewer = Quantiles::of(ns[..499].to_vec());
        assert_eq!((fewer.p90_ms.is_some(), fewer.p99_ms), (true, None));
        assert_eq!(Quantiles::of(vec![]), Quantiles::default());
    }

    /// Quantiles from numpy, of series with values that are missing; `quantiles.py` beside it produces them.
    const REFERENCE: &str = include_str!("../tests/fixtures/quantiles.json");

    #[derive(Deserialize)]
    struct Case {
        ns: Vec<u64>,
        missing: u64,
        p50_ms: Option<f64>,
        p90_ms: Option<f64>,
        p99_ms: Option<f64>,
        max_ms: Option<f64>,
    }

    #[test]
    fn quantiles_with_missing_values_are_those_of_numpy() {
        let cases: Vec<Case> = serde_json::from_str(REFERENCE).expect("the fixture");
        assert!(cases.len() >= 200);
        for case in cases {
            let right = Quantiles {
                p50_ms: case.p50_ms,
                p90_ms: case.p90_ms,
                p99_ms: case.p99_ms,
                max_ms: case.max_ms,
            };
            let (there, missing) = (case.ns.len() as u64, case.missing);
            for (q, value) in [
                (0.5, right.p50_ms),
                (0.9, right.p90_ms),
                (0.99, right.p99_ms),
            ] {
                let is_enough = rank((there + missing) as usize, q).is_some();
                let falls = Quantiles::falls_among_missing(q, there, missing);
                assert_eq!(
                    falls,
                    is_enough && value.is_none(),
                    "{q} of {there} and {missing}"
                );
            }
            assert_eq!(Quantiles::with_missing(case.ns, missing), right);
        }
    }

    #[test]
    fn a_message_without_an_answer_is_later_than_all_that_have_one() {
        // 400 of 2000 answered within 50 ms: no quantile but the tenth of them is known.
        let answered: Vec<u64> = (0..400).map(|i| 10_000_000 + i * 100_000).collect();
        let all = Quantiles::with_missing(answered.clone(), 1600);
        assert_eq!(all, Quantiles::default());
        let half = Quantiles::with_missing(answered, 200);
        assert_eq!((half.p50_ms, half.p90_ms), (Some(39.9), None));
        assert_eq!((half.p99_ms, half.max_ms), (None, None));
    }

    #[test]
    fn of_two_values_in_the_middle_a_median_is_either_or_their_mean() {
        let mut values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(median(&values), Some(2.5));
        assert_eq!(lower_median(&mut values, f64::total_cmp), Some(2.0));
        assert_eq!(upper_median(&mut values, f64::total_cmp), Some(3.0));
        assert_eq!(upper_median(&mut [5u64, 9, 7], Ord::cmp), Some(7));
        assert_eq!(lower_median(&mut [5u64, 9, 7], Ord::cmp), Some(7));
        assert_eq!(upper_median::<u64>(&mut [], Ord::cmp), None);
        assert_eq!(lower_median::<u64>(&mut [], Ord::cmp), None);
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[f64::NEG_INFINITY, f64::INFINITY]), None);
    }

    /// As many as decide that a percentile is not exceeded with 99 % confidence: 459 for the 99th, as `MLPerf` counts.
    #[test]
    fn a_percentile_needs_the_values_that_vouch_for_it() {
        let values: Vec<f64> = (1..=10_000).map(f64::from).collect();
        for (share, least) in [(0.5_f64, 10), (0.9, 50), (0.99, 500), (0.999, 5_000)] {
            let vouching = (0.01_f64.ln() / share.ln()).ceil() as usize;
            assert!(least >= vouching, "{share}: {vouching}");
            assert_eq!(percentile(&values[..least - 1], share), None, "{share}");
            let value = percentile(&values[..least], share);
            assert_eq!(value, Some((least as f64 * share).ceil()), "{share}");
        }
        assert_eq!(percentile(&[], 0.5), None);
    }

    proptest! {
        #[test]
        fn a_quantile_has_its_share_of_values_at_or_below_it_and_less_below(
            ns in prop::collection::vec(0u64..10_000, 0..2000),
        ) {
            let all = Quantiles::of(ns.clone());
            let n = ns.len() as f64;
            prop_assert_eq!(all.max_ms, ns.iter().max().copied().map(ms));
            for (q, found, enough) in [(0.5, all.p50_ms, 10), (0.9, all.p90_ms, 50), (0.99, all.p99_ms, 500)] {
                prop_assert_eq!(found.is_some(), ns.len() >= enough);
                if let Some(found) = found {
                    let at_or_below = ns.iter().filter(|ns| ms(**ns) <= found).count() as f64;
                    let below = ns.iter().filter(|ns| ms(**ns) < found).count() as f64;
                    prop_assert!(at_or_below >= q * n - 1e-6 && below < q * n + 1e-6);
                }
            }
        }

        #[test]
        fn a_line_through_exact_points_has_their_slope(
            slope in -2.0f64..2.0, offset in -1e3f64..1e3, n in 2u32..500,
        ) {
            let mut line = Line::default();
            for x in 0..n {
                line.push(f64::from(x), offset + slope * f64::from(x));
            }
            prop_assert!((line.slope().expect("two points") - slope).abs() < 1e-9);
        }

        #[test]
        fn moments_in_one_pass_are_those_of_two(values in prop::collection::vec(0.0f64..1e4, 1..200)) {
            let mut moments = Moments::default();
            values.iter().for_each(|x| moments.push(*x));
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
            let spread = moments.spread().expect("at least one");
            prop_assert!((spread.avg_ms - mean).abs() < 1e-9 * 1e4);
            prop_assert!((spread.sd_ms - variance.sqrt()).abs() < 1e-9 * 1e4);
        }
    }
}
