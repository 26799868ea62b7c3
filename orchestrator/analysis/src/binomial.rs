//! The binomial distribution, to some twelve digits for a million trials and more: how likely are `k` heads, at
//! most `k`, at least `k`?
//!
//! A probability is C. Loader's, "Fast and accurate computation of binomial probabilities" (2000): what is left of
//! Stirling's formula, and two deviances, without the cancellation that logarithms of factorials have. A tail is
//! the sum of its terms from the largest on, each from the one before, until the next ones no longer count. So
//! nothing underflows that is not itself below the least number that there is.

use std::f64::consts::TAU;

/// Probability of success and of failure. Both are kept, since 1 − p loses the digits of a small one.
#[derive(Debug, Clone, Copy)]
struct Odds {
    success: f64,
    failure: f64,
}

impl Odds {
    fn of(p: f64) -> Odds {
        Odds {
            success: p,
            failure: 1.0 - p,
        }
    }

    fn turned(self) -> Odds {
        Odds {
            success: self.failure,
            failure: self.success,
        }
    }
}

/// The probability of `k` or more successes in `n` trials, each with probability `p` from 0 to 1.
#[must_use]
pub fn at_least(k: usize, n: usize, p: f64) -> f64 {
    tail(k, n, Odds::of(p))
}

/// The probability of `k` or fewer successes in `n` trials, each with probability `p` from 0 to 1.
#[must_use]
pub fn at_most(k: usize, n: usize, p: f64) -> f64 {
    match n.checked_sub(k) {
        // So many failures or more.
        Some(failures) => tail(failures, n, Odds::of(p).turned()),
        None => 1.0,
    }
}

/// How many of `n` sorted values lie outside the interval of their median on each side, by order statistics: the
/// largest k for which `n` flips of a fair coin give at most k heads with a probability of at most half of
/// 1 − `confidence`. 0 also if the whole range is less certain than `confidence`.
#[must_use]
pub fn outside_median(n: usize, confidence: f64) -> usize {
    let side = (1.0 - confidence) / 2.0;
    // Below half of n the probability rises with k.
    let (mut low, mut high) = (0, n / 2 + 1);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if at_most(middle, n, 0.5) <= side {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The probability of `k` or more successes.
fn tail(k: usize, n: usize, p: Odds) -> f64 {
    if k == 0 {
        1.0
    } else if k > n {
        0.0
    } else if k as f64 > n as f64 * p.success {
        rising(k, n, p)
    } else {
        // The shorter side: so many failures or more, which is above their mean.
        1.0 - rising(n - k + 1, n, p.turned())
    }
}

/// The sum of the terms from `k` on, which lies above the mean, so that each is smaller than the one before.
fn rising(k: usize, n: usize, p: Odds) -> f64 {
    let odds = p.success / p.failure;
    let mut term = probability(k, n, p);
    let mut sum = 0.0;
    for i in k..=n {
        let before = sum;
        sum += term;
        if sum <= before {
            break;
        }
        term *= (n - i) as f64 / (i + 1) as f64 * odds;
    }
    sum.min(1.0)
}

/// The probability of exactly `k` successes.
fn probability(k: usize, n: usize, p: Odds) -> f64 {
    let certain = |is_so: bool| if is_so { 1.0 } else { 0.0 };
    if p.success <= 0.0 {
        return certain(k == 0);
    }
    if p.failure <= 0.0 {
        return certain(k == n);
    }
    let (all, some, others) = (n as f64, k as f64, (n - k) as f64);
    if k == 0 || k == n {
        let (least, most) = (p.success.min(p.failure), p.success.max(p.failure));
        // The larger of the two by what it lacks to 1.
        let log = |one: f64| {
            if one >= most {
                libm::log1p(-least)
            } else {
                libm::log(one)
            }
        };
        return libm::exp(all * log(if k == 0 { p.failure } else { p.success }));
    }
    let exponent = left_of_stirling(n)
        - left_of_stirling(k)
        - left_of_stirling(n - k)
        - deviance(some, all * p.success)
        - deviance(others, all * p.failure);
    (all / (TAU * some * others)).sqrt() * libm::exp(exponent)
}

/// ln n! − ln(√(2πn) (n/e)ⁿ), for n of at least 1.
fn left_of_stirling(n: usize) -> f64 {
    let x = n as f64;
    if n <= 15 {
        let factorial: f64 = (1..=n).map(|i| i as f64).product();
        return libm::log(factorial / (TAU * x).sqrt()) - x * libm::log(x) + x;
    }
    let square = x * x;
    let inner = 1.0 / 1260.0 - (1.0 / 1680.0 - 1.0 / 1188.0 / square) / square;
    (1.0 / 12.0 - (1.0 / 360.0 - inner / square) / square) / x
}

/// x ln(x/m) + m − x, for x and its mean m above 0; by a series where the two are near each other.
fn deviance(x: f64, mean: f64) -> f64 {
    let off = x - mean;
    if off.abs() >= 0.1 * (x + mean) {
        return x * libm::log(x / mean) - off;
    }
    let ratio = off / (x + mean);
    let square = ratio * ratio;
    let mut sum = off * ratio;
    let mut power = 2.0 * x * ratio;
    for odd in (3_u32..).step_by(2) {
        power *= square;
        let next = sum + power / f64::from(odd);
        if next == sum {
            break;
        }
        sum = next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::Deserialize;

    use super::*;

    /// Tails from mpmath, with sixty digits, of trials up to a million; `binomial.py` beside it produces them.
    const REFERENCE: &str = include_str!("../tests/fixtures/binomial.json");

    #[derive(Deserialize)]
    struct Case {
        k: usize,
        n: usize,
        p: f64,
        at_most: f64,
        at_least: f64,
    }

    #[test]
    fn both_tails_are_those_of_sixty_digits_for_up_to_a_million_trials() {
        let cases: Vec<Case> = serde_json::from_str(REFERENCE).expect("the fixture");
        assert!(cases.len() > 2000 && cases.iter().any(|case| case.n == 1_000_000));
        for Case {
            k,
            n,
            p,
            at_most: low,
            at_least: high,
        } in cases
        {
            for (own, right) in [(at_most(k, n, p), low), (at_least(k, n, p), high)] {
                let off = (own - right).abs();
                assert!(
                    off <= 1e-11 * right + 1e-300,
                    "{k} of {n} at {p}: {own}, not {right}"
                );
            }
        }
    }

    #[test]
    fn what_is_certain_and_what_cannot_be_are_exactly_so() {
        assert_eq!((at_least(0, 5, 0.0), at_least(1, 5, 0.0)), (1.0, 0.0));
        assert_eq!((at_most(5, 5, 1.0), at_most(4, 5, 1.0)), (1.0, 0.0));
        assert_eq!((at_least(0, 0, 0.3), at_most(0, 0, 0.3)), (1.0, 1.0));
        assert_eq!(at_least(6, 5, 0.5), 0.0);
        // 0.5 to the 2000 is below the least number that there is; the tail to the mean is not.
        assert!((at_most(1000, 2000, 0.5) - 0.508_919_505_572_927_2).abs() < 1e-12);
    }

    #[test]
    fn the_median_s_interval_leaves_out_what_tables_of_the_sign_test_say() {
        for (n, outside) in [
            (0, 0),
            (1, 0),
            (5, 0),
            (6, 0),
            (9, 1),
            (10, 1),
            (20, 5),
            (25, 7),
        ] {
            assert_eq!(outside_median(n, 0.95), outside, "{n}");
        }
        // The largest k whose scipy.stats.binom.cdf(k, n, 0.5) is at most 0.025.
        for (n, outside) in [
            (1074, 504),
            (1075, 504),
            (1076, 505),
            (2000, 955),
            (1_000_000, 499_019),
        ] {
            assert_eq!(outside_median(n, 0.95), outside, "{n}");
        }
    }

    proptest! {
        /// The definition, which small numbers allow.
        #[test]
        fn a_tail_is_the_sum_of_its_terms(n in 1usize..25, k in 0usize..27, p in 0.0..=1.0f64) {
            let choose = |i: usize| (0..i).fold(1.0, |c, j| c * (n - j) as f64 / (j + 1) as f64);
            let terms = (k..=n).map(|i| choose(i) * p.powf(i as f64) * (1.0 - p).powf((n - i) as f64));
            prop_assert!((at_least(k, n, p) - terms.sum::<f64>()).abs() < 1e-12);
        }

        #[test]
        fn the_two_tails_of_neighbours_make_one(n in 0usize..=1_000_000, part in 0.0..=1.0f64, p in 0.0..=1.0f64) {
            let k = (part * n as f64) as usize;
            let (low, high) = (at_most(k, n, p), at_least(k + 1, n, p));
            prop_assert!((0.0..=1.0).contains(&low) && (0.0..=1.0).contains(&high));
            prop_assert!((low + high - 1.0).abs() < 1e-9, "{low} + {high}");
        }
    }
}
