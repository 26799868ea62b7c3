//! Tests on paired differences: does one side tend to be above the other?
//!
//! The tests are exact, by counting, and ask each direction by itself: an alarm that B is worse is false with the
//! probability of that one side, whatever is thought of the other. They assume nothing about the distribution of the
//! differences beyond what each test states. A difference may be infinite: it is larger than any finite one, and as
//! large as another infinite one. Differences of zero favour neither side and are left out. The caller decides what
//! the differences are of and how large one has to be to matter.

use std::cmp::Ordering;
use std::f64::consts::SQRT_2;

use crate::binomial::{at_least, at_most, outside_median};

/// The most differences whose rank sums are counted. With more, a normal distribution approximates
/// them to some 1e-4.
const COUNTED: usize = 50;

/// Most pairs that [`to_tell`] thinks of; the largest plan has as many cells.
const MOST: usize = 100_000;

/// The probabilities that, by chance alone, differences lie on a side as far as these do, or farther. 1 each if none
/// differs from zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// As far above zero.
    pub above: f64,
    /// As far below zero.
    pub below: f64,
}

impl Sides {
    const NONE: Sides = Sides {
        above: 1.0,
        below: 1.0,
    };

    /// The probability of lying as far on either side: twice that of the less likely one.
    #[must_use]
    pub fn either(self) -> f64 {
        (2.0 * self.above.min(self.below)).min(1.0)
    }
}

/// The probabilities of the sign test: that as many flips of a fair coin as there are nonzero differences give as many
/// heads, or tails.
///
/// Assumes only that the differences are independent.
#[must_use]
pub fn sign_test(differences: &[f64]) -> Sides {
    let above = differences.iter().filter(|d| **d > 0.0).count();
    let below = differences.iter().filter(|d| **d < 0.0).count();
    let n = above + below;
    if n == 0 {
        return Sides::NONE;
    }
    Sides {
        above: at_least(above, n, 0.5),
        below: at_least(below, n, 0.5),
    }
}

/// The probabilities of the signed-rank test (Wilcoxon 1945): do the larger differences tend to be on one side?
///
/// Assumes that the differences are distributed symmetrically about their median; then it has more
/// power than the sign test. Equal magnitudes share their mean rank, and the counting takes that into
/// account.
#[must_use]
pub fn signed_rank_test(differences: &[f64]) -> Sides {
    let mut differences: Vec<f64> = differences.to_vec();
    differences.retain(|d| *d != 0.0 && !d.is_nan());
    differences.sort_by(|one, other| one.abs().total_cmp(&other.abs()));
    if differences.is_empty() {
        return Sides::NONE;
    }
    // Twice the ranks: integers even where mean ranks are not.
    let mut ranks: Vec<usize> = Vec::with_capacity(differences.len());
    for tie in differences.chunk_by(|one, other| one.abs() == other.abs()) {
        let before = ranks.len();
        ranks.extend(tie.iter().map(|_| 2 * before + tie.len() + 1));
    }
    let above = differences.iter().zip(&ranks);
    let above: usize = above.filter(|(d, _)| **d > 0.0).map(|(_, r)| r).sum();
    let all: usize = ranks.iter().sum();
    let up_to = |sum: usize| {
        if ranks.len() <= COUNTED {
            share_up_to(&ranks, sum).min(1.0)
        } else {
            normal(&ranks, sum)
        }
    };
    // A sum above zero as large is one below zero as small, and every choice of signs has its mirror image.
    Sides {
        above: up_to(all - above),
        below: up_to(above),
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

/// The share of all subsets of `ranks` whose sum is at most `sum`, where there are too many to count.
fn normal(ranks: &[usize], sum: usize) -> f64 {
    let mean = ranks.iter().map(|rank| *rank as f64).sum::<f64>() / 2.0;
    let squares: f64 = ranks.iter().map(|rank| (*rank as f64).powi(2)).sum();
    let z = (sum as f64 - mean) / (squares / 4.0).sqrt();
    libm::erfc(-z / SQRT_2) / 2.0
}

/// The least probability that either test can give for `pairs` differences: that for all on one side.
#[must_use]
pub fn least_probability(pairs: usize) -> f64 {
    at_most(0, pairs, 0.5)
}

/// The value that the median of all differences does not exceed with a confidence of 1 − `level`, by order statistics;
/// infinite if there are too few of them to say.
#[must_use]
pub fn median_at_most(differences: &[f64], level: f64) -> f64 {
    let n = differences.len();
    if least_probability(n) > level {
        return f64::INFINITY;
    }
    let mut sorted = differences.to_vec();
    sorted.sort_by(f64::total_cmp);
    let outside = outside_median(n, 1.0 - 2.0 * level);
    sorted
        .get(n - 1 - outside)
        .copied()
        .unwrap_or(f64::INFINITY)
}

/// How many pairs would tell whether the median of all differences is beyond a limit, if the share beyond it stays
/// what it is in `pairs` of them, `beyond` of which are. That it is beyond must hold among `tests` tests together, that
/// it is not in this one alone. Counted by the sign test. `None` if no number would do that a plan can have.
#[must_use]
pub fn to_tell(pairs: usize, beyond: usize, tests: usize, level: f64) -> Option<usize> {
    let within = pairs.checked_sub(beyond)?;
    let (fewer, level) = match beyond.cmp(&within) {
        Ordering::Less => (beyond, level),
        Ordering::Greater => (within, level / tests.max(1) as f64),
        Ordering::Equal => return None,
    };
    let tells = |n: usize| at_most((fewer * n).div_ceil(pairs), n, 0.5) < level;
    let (mut low, mut high) = (pairs, pairs + 1);
    while !tells(high) {
        if high >= MOST {
            return None;
        }
        (low, high) = (high, (2 * high).min(MOST));
    }
    while high - low > 1 {
        let middle = low.midpoint(high);
        if tells(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
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
