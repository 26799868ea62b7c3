//! Whether two counts of something rare can have the same rate.

use analysis::Metrics;
use analysis::statistics::share;

use super::source::Source;
use report::group::Estimate;

/// How often something was found, and in how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Count {
    pub(super) found: u64,
    pub(super) of: u64,
}

impl Count {
    /// The count over all runs of a group. `measured` gives a share of the intervals, and the number
    /// of items between which the intervals are. `None` if there are no intervals.
    pub(super) fn over(
        source: &Source<'_>,
        measured: fn(&Metrics) -> (Option<f64>, u64),
    ) -> Option<Count> {
        let runs = source.group.runs.iter();
        let mut whole = Count { found: 0, of: 0 };
        for (share, n) in runs.filter_map(|run| run.metrics.as_ref()).map(measured) {
            let intervals = n.saturating_sub(1);
            whole.found += (share.unwrap_or(0.0) * intervals as f64).round() as u64;
            whole.of += intervals;
        }
        (whole.of > 0).then_some(whole)
    }

    /// The share with the interval of a sample; `None` if `of` is 0.
    pub(super) fn sampled(self) -> Option<Estimate> {
        Estimate::share(self.found, self.of)
    }

    /// The share as an exact number; `None` if `of` is 0.
    pub(super) fn share(self) -> Option<Estimate> {
        share(self.found, self.of).map(|found| Estimate::exact(found, self.of))
    }
}

/// A probability below this, at either end, is not taken for chance.
pub(super) const TAIL: f64 = 0.025;
/// If more than this are found in all, the normal distribution replaces the exact sum; it is as good
/// by then.
const EXACT_MAX: u64 = 500;

/// The range of shares that can be found in `of` others at the rate of `theirs`, at the 5 % level.
///
/// By the conditional test of two Poisson rates: given the total that was found, each find falls into
/// either count in proportion to its size, whatever the rate. So the number found in `of` is
/// binomial.
pub(super) fn alike(theirs: Count, of: u64) -> (f64, f64) {
    let expected = share(theirs.found, theirs.of).unwrap_or(0.0) * of as f64;
    let likely = |found: &u64| is_alike(theirs, Count { found: *found, of });
    let centre = (expected.round() as u64).min(of);
    let high = (centre..=of).take_while(likely).last().unwrap_or(centre);
    let low = (0..=centre)
        .rev()
        .take_while(likely)
        .last()
        .unwrap_or(centre);
    let share_of = |found| share(found, of).unwrap_or(0.0);
    (share_of(low), share_of(high))
}

fn is_alike(a: Count, b: Count) -> bool {
    let all = a.found + b.found;
    let p = share(b.of, a.of + b.of).unwrap_or(0.0);
    if all > EXACT_MAX {
        let sd = (all as f64 * p * (1.0 - p)).sqrt();
        return (b.found as f64 - all as f64 * p).abs() <= 1.96 * sd;
    }
    // P(X = 0), then each term from the one before.
    let odds = p / (1.0 - p);
    let mut term = (1.0 - p).powi(i32::try_from(all).unwrap_or(i32::MAX));
    let (mut below, mut k) = (0.0, 0);
    while k < b.found {
        below += term;
        term *= (all - k) as f64 / (k + 1) as f64 * odds;
        k += 1;
    }
    let (at_most, at_least) = (below + term, 1.0 - below);
    at_most > TAIL && at_least > TAIL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shorter_run_may_well_find_none_of_what_is_rare() {
        // 2 of 2000 against a sample of 400: 0.4 are expected.
        let (low, high) = alike(Count { found: 2, of: 2000 }, 400);
        assert_eq!(low, 0.0);
        assert!((1.0 / 400.0..=4.0 / 400.0).contains(&high), "{high}");
        // 30 of 5900 against a sample of 1200: 6 are expected, and none at all is too few.
        let (low, high) = alike(
            Count {
                found: 30,
                of: 5900,
            },
            1200,
        );
        assert!(low > 0.0 && high < 20.0 / 1200.0, "{low} {high}");
        // None of 6000 against a sample of 1200: one or two can be chance, ten cannot.
        let (low, high) = alike(Count { found: 0, of: 6000 }, 1200);
        assert_eq!(low, 0.0);
        assert!((1.0 / 1200.0..10.0 / 1200.0).contains(&high), "{high}");
    }

    #[test]
    fn many_are_judged_by_the_normal_law_much_as_by_the_exact_sum() {
        let (low, high) = alike(
            Count {
                found: 13_717,
                of: 55_000,
            },
            2700,
        );
        assert!(
            (0.23..0.24).contains(&low) && (0.26..0.27).contains(&high),
            "{low} {high}"
        );
        assert_eq!(alike(Count { found: 0, of: 0 }, 0), (0.0, 0.0));
    }
}
