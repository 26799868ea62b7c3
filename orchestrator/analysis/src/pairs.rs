//! Tests on paired differences: does one side tend to be above the other?
//!
//! The tests are two-sided and exact, by counting. They assume nothing about the distribution of the
//! differences beyond what each test states. A difference may be infinite: it is larger than any
//! finite one, and as large as another infinite one. Differences of zero favour neither side and are
//! left out. The caller decides what the differences are of and how large one has to be to matter.

use std::f64::consts::SQRT_2;

/// The most differences whose rank sums are counted. With more, a normal distribution approximates
/// them to some 1e-4.
const COUNTED: usize = 50;

/// The probability of the sign test: that as many flips of a fair coin as there are nonzero
/// differences give a number of heads at least this far from half. 1 if there are none.
///
/// Assumes only that the differences are independent.
#[must_use]
pub fn sign_test(differences: &[f64]) -> f64 {
    let above = differences.iter().filter(|d| **d > 0.0).count();
    let below = differences.iter().filter(|d| **d < 0.0).count();
    let (n, fewer) = (above + below, above.min(below));
    // P(X = k) from P(X = k - 1), in logarithms: 0.5^n is zero in floating point beyond n = 1074.
    let mut log = -(n as f64) * std::f64::consts::LN_2;
    let mut tail = log.exp();
    for k in 1..=fewer {
        log += ((n - k + 1) as f64 / k as f64).ln();
        tail += log.exp();
    }
    (2.0 * tail).min(1.0)
}

/// The probability of the signed-rank test (Wilcoxon 1945): do the larger differences tend to be on
/// one side? 1 if there are no nonzero differences.
///
/// Assumes that the differences are distributed symmetrically about their median; then it has more
/// power than the sign test. Equal magnitudes share their mean rank, and the counting takes that into
/// account.
#[must_use]
pub fn signed_rank_test(differences: &[f64]) -> f64 {
    let mut differences: Vec<f64> = differences.to_vec();
    differences.retain(|d| *d != 0.0 && !d.is_nan());
    differences.sort_by(|one, other| one.abs().total_cmp(&other.abs()));
    // Twice the ranks: integers even where mean ranks are not.
    let mut ranks: Vec<usize> = Vec::with_capacity(differences.len());
    for tie in differences.chunk_by(|one, other| one.abs() == other.abs()) {
        let before = ranks.len();
        ranks.extend(tie.iter().map(|_| 2 * before + tie.len() + 1));
    }
    let above = differences.iter().zip(&ranks);
    let above: usize = above.filter(|(d, _)| **d > 0.0).map(|(_, r)| r).sum();
    let all: usize = ranks.iter().sum();
    let fewer = above.min(all - above);
    if ranks.len() <= COUNTED {
        (2.0 * share_up_to(&ranks, fewer)).min(1.0)
    } else {
        normal(&ranks, fewer)
    }
}

/// The share of all subsets of `ranks` whose sum is at most `sum`.
fn share_up_to(ranks: &[usize], sum: usize) -> f64 {
    // Larger sums need no counting.
    let mut shares = vec![0.0; sum + 1];
    if let Some(none) = shares.first_mut() {
        *none = 1.0;
    }
    for rank in ranks {
        for at in (0..=sum).rev() {
            let with = at.checked_sub(*rank).map_or(0.0, |less| shares[less]);
            shares[at] = f64::midpoint(shares[at], with);
        }
    }
    shares.iter().sum()
}

/// The probability of the signed-rank test where there are too many differences to count.
fn normal(ranks: &[usize], fewer: usize) -> f64 {
    let mean = ranks.iter().sum::<usize>() as f64 / 2.0;
    let squares: f64 = ranks.iter().map(|rank| (*rank as f64).powi(2)).sum();
    let z = (fewer as f64 - mean) / (squares / 4.0).sqrt();
    libm::erfc(z.abs() / SQRT_2).min(1.0)
}

/// The least probability that either test can give for `pairs` differences: that for all on one side.
#[must_use]
pub fn least_probability(pairs: usize) -> f64 {
    2f64.powi(1 - i32::try_from(pairs).unwrap_or(i32::MAX))
        .min(1.0)
}

/// Raises the probabilities of several tests so that the chance of one or more false alarms among all
/// of them stays below the level of a single test (Holm 1979). Returns them in the order given.
#[must_use]
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|one, other| probabilities[*one].total_cmp(&probabilities[*other]));
    let mut raised = vec![1.0; probabilities.len()];
    let mut most = 0.0f64;
    for (before, at) in order.into_iter().enumerate() {
        let others = (probabilities.len() - before) as f64;
        most = most.max((others * probabilities[at]).min(1.0));
        raised[at] = most;
    }
    raised
}

/// Which of several tests are worth making: those that could stay below `level` after [`holm`] over
/// all tests made, judged by the least probability that each can give (Tarone 1990).
///
/// The choice depends only on the number of pairs of each test and not on their values, so leaving
/// the others out makes no false alarm more likely.
#[must_use]
pub fn worth_making(least_probabilities: &[f64], level: f64) -> Vec<bool> {
    let could = |k: usize| {
        let limit = level / k as f64;
        least_probabilities.iter().map(move |least| *least < limit)
    };
    let enough = (1..).find(|k| could(*k).filter(|could| *could).count() <= *k);
    could(enough.unwrap_or(1)).collect()
}

#[cfg(test)]
mod tests;
