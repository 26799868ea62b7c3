//! The share of all runs that some runs stand for: exact bounds, and how many runs are enough for one.
//!
//! The bounds are those of C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits illustrated
//! in the case of the binomial", Biometrika 26 (1934), 404-413, each one-sided: if the share were smaller than the
//! lower bound, as many successes as were seen would have a probability of less than 1 − confidence; if it were
//! larger than the upper bound, as few.
//!
//! The share is found by bisection on the tail of the [binomial distribution](crate::binomial).

use crate::binomial::at_least;

/// Most runs that [`enough`] thinks of; the largest plan has as many cells.
const MOST: usize = 100_000;

/// Lower and upper bound of a share of which `met` of `n` were seen, each with this confidence. Without a run,
/// 0 and 1.
#[must_use]
pub fn bounds(met: usize, n: usize, confidence: f64) -> (f64, f64) {
    let rest = 1.0 - confidence;
    let lower = if met == 0 {
        0.0
    } else {
        // The probability of so many rises with the share.
        bisect(|p| at_least(met, n, p) < rest)
    };
    let upper = if met >= n {
        1.0
    } else {
        // The probability of so few is that of so many failures, which rises with their share.
        1.0 - bisect(|q| at_least(n - met, n, q) < rest)
    };
    (lower, upper)
}

/// Lower and upper bound of a share of which `met` of `n` were seen, both together with this confidence: the share of
/// all runs lies between them in so many cases, or more.
#[must_use]
pub fn interval(met: usize, n: usize, confidence: f64) -> (f64, f64) {
    // Half of what is left over lies beyond each end.
    bounds(met, n, 1.0 - (1.0 - confidence) / 2.0)
}

/// The least number of runs whose lower bound is at least `share`, if no more than `missed` of them miss it;
/// `None` if more than a plan can have.
#[must_use]
pub fn enough(missed: usize, share: f64, confidence: f64) -> Option<usize> {
    // The lower bound is at least `share` if so many are unlikely with that share: no need to find the bound.
    let is_enough = |n: usize| at_least(n - missed, n, share) <= 1.0 - confidence;
    let (mut low, mut high) = (missed, missed + 1);
    while !is_enough(high) {
        if high >= MOST {
            return None;
        }
        (low, high) = (high, (2 * high).min(MOST));
    }
    // With more runs that meet it the bound only rises.
    while high - low > 1 {
        let middle = low.midpoint(high);
        if is_enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// The point between 0 and 1 up to which `is_below` is true.
fn bisect(is_below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    // Until two neighbours are the same number.
    for _ in 0..60 {
        let middle = low.midpoint(high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.midpoint(high)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// From Python's fractions, which are exact, by the definition.
    #[test]
    fn bounds_are_those_of_exact_fractions() {
        for (met, n, lower, upper) in [
            (20, 20, 0.860_891_66, 1.0),
            (18, 20, 0.717_381_48, 0.981_934_80),
            (9, 10, 0.605_836_70, 0.994_883_80),
            (0, 5, 0.0, 0.450_719_73),
            (0, 0, 0.0, 1.0),
        ] {
            let (l, u) = bounds(met, n, 0.95);
            assert!(
                (l - lower).abs() < 1e-7 && (u - upper).abs() < 1e-7,
                "{met} of {n}: {l} {u}"
            );
        }
    }

    /// All of n meet it with the lower bound 0.05^(1/n).
    #[test]
    fn ninety_percent_need_twenty_nine_runs_that_all_meet_it() {
        assert_eq!(enough(0, 0.9, 0.95), Some(29));
        assert_eq!(enough(0, 0.99, 0.95), Some(299));
        assert_eq!(enough(1, 0.9, 0.95), Some(46));
        assert_eq!(enough(0, 0.999_999, 0.95), None);
    }

    proptest! {
        /// The definition: at a bound, what was seen or more of it has the probability 1 - confidence.
        #[test]
        fn a_bound_is_where_what_was_seen_becomes_unlikely(
            n in 1usize..300, part in 0.0..=1.0f64, confidence in 0.5..0.999f64,
        ) {
            let met = (part * n as f64) as usize;
            let (lower, upper) = bounds(met, n, confidence);
            let share = met as f64 / n as f64;
            prop_assert!((0.0..=1.0).contains(&lower) && lower <= share && share <= upper && upper <= 1.0);
            let rest = 1.0 - confidence;
            if met > 0 {
                prop_assert!((at_least(met, n, lower) - rest).abs() < 1e-9);
            }
            if met < n {
                prop_assert!((1.0 - at_least(met + 1, n, upper) - rest).abs() < 1e-9);
            }
        }

        #[test]
        fn so_many_are_enough_and_one_less_is_not(
            missed in 0usize..5, share in 0.5..0.98f64, confidence in 0.6..0.99f64,
        ) {
            let n = enough(missed, share, confidence).expect("few");
            prop_assert!(bounds(n - missed, n, confidence).0 >= share);
            prop_assert!(n == missed || n == missed + 1 || bounds(n - 1 - missed, n - 1, confidence).0 < share);
        }
    }
}
