//! Runs that differ only in their repeat, and their medians.

mod estimate;

use analysis::Run;
use analysis::binomial::outside_median;
use analysis::statistics::quantile_of_sorted;
use analysis::variety::is_one_run;
use serde::Serialize;

/// The complete runs of one topology, client, setup, mode and rate, in order of repeat.
#[derive(Debug, Clone)]
pub struct Group<'a> {
    /// The complete runs.
    pub runs: Vec<&'a Run>,
    /// Number of planned runs, complete or not.
    pub planned: usize,
}

impl<'a> Group<'a> {
    /// The complete runs among those of one kind.
    pub fn complete(kind: impl Iterator<Item = &'a Run>) -> Group<'a> {
        let planned: Vec<&Run> = kind.collect();
        Group {
            planned: planned.len(),
            runs: planned
                .into_iter()
                .filter(|run| run.is_complete())
                .collect(),
        }
    }

    /// The ids of its runs.
    #[must_use]
    pub fn ids(&self) -> Vec<String> {
        self.runs.iter().map(|run| run.cell.id.clone()).collect()
    }

    /// The median of a figure; `None` if it is not finite, since half of the runs do not have the
    /// figure.
    pub fn median(&self, figure: impl Fn(&Run) -> Option<f64>) -> Option<Estimate> {
        self.median_or_never(figure)
            .filter(|median| median.value.is_finite())
    }

    /// The same of a figure that has to be read.
    ///
    /// # Errors
    /// The first of `figure`.
    pub fn try_median<E>(
        &self,
        figure: impl Fn(&Run) -> Result<Option<f64>, E>,
    ) -> Result<Option<Estimate>, E> {
        let values = self.runs.iter().map(|run| figure(run));
        let values = values.collect::<Result<Vec<_>, E>>()?;
        let median = self.median_of(&values);
        Ok(median.filter(|median| median.value.is_finite()))
    }

    /// The median of a figure that runs may never reach: infinite if half of them did not, as a step
    /// that never settled is later than any other.
    pub fn median_or_never(&self, figure: impl Fn(&Run) -> Option<f64>) -> Option<Estimate> {
        let values: Vec<_> = self.runs.iter().map(|run| figure(run)).collect();
        self.median_of(&values)
    }

    /// The median of a value for each run.
    fn median_of(&self, values: &[Option<f64>]) -> Option<Estimate> {
        let value = |value: &Option<f64>| value.unwrap_or(f64::INFINITY);
        let values: Vec<f64> = values.iter().map(value).collect();
        // One run that was made several times is no sample of anything.
        let is_one = is_one_run(self.runs.iter().map(|run| &run.summary));
        let distinct = if is_one { &values[..1] } else { &values };
        Estimate::median_or_never(distinct)
    }

    /// The median settling, ms; infinite if half of the runs never settled.
    pub fn settling_ms(&self) -> Option<Estimate> {
        self.median_or_never(|run| run.summary.settling_ms)
    }
}

/// The fewest values for an interval. The median of the distribution of six values is between the
/// least and the greatest of them with 97 % (1 - 2/2^6). With five values it is 94 %: no two of them
/// enclose it with 95 %.
pub const INTERVAL_MIN: u64 = 6;

/// A figure with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The figure itself: a median over runs, or one run's.
    pub value: f64,
    /// The interval's lower end; equal to `value` if the figure is exact, and minus infinity if there
    /// are too few values for an interval.
    pub low: f64,
    /// The interval's upper end; infinite if there is no interval, or if it includes runs that never
    /// reached the figure.
    pub high: f64,
    /// Number of runs or messages that it is based on.
    pub n: u64,
}

impl Estimate {
    /// The median of values with its 95 % interval by order statistics (binomial, exact). With fewer
    /// than [`INTERVAL_MIN`] values there is no interval.
    ///
    /// `None` without values, or if the median itself is infinite.
    #[must_use]
    pub fn median(values: &[f64]) -> Option<Estimate> {
        Estimate::median_or_never(values).filter(|median| median.value.is_finite())
    }

    /// The median over runs, some of which may never have reached the figure: infinite if half of
    /// them did not. `None` without values.
    pub fn median_or_never(values: &[f64]) -> Option<Estimate> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let middle = n.checked_sub(1)?;
        let value = quantile_of_sorted(&sorted, 0.5)?;
        let below = outside_median(n, 0.95);
        Some(Estimate::within(
            value,
            (sorted[below], sorted[middle - below]),
            n as u64,
        ))
    }

    /// A value with the ends of its interval, or without an interval if `n` values are too few for one.
    pub fn within(value: f64, ends: (f64, f64), n: u64) -> Estimate {
        let (low, high) = if n < INTERVAL_MIN {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            ends
        };
        Estimate {
            value,
            low,
            high,
            n,
        }
    }

    /// Whether the figure has an interval; one of its ends may be infinite.
    #[must_use]
    pub fn has_interval(&self) -> bool {
        self.low > f64::NEG_INFINITY || self.high < f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of 0.5 to the n is no number any more from 1075 on.
    #[test]
    fn the_median_of_thousands_of_values_has_an_interval_as_that_of_ten() {
        for (n, low) in [
            (10, 2.0),
            (1074, 505.0),
            (1075, 505.0),
            (1076, 506.0),
            (100_000, 49_690.0),
        ] {
            let values: Vec<f64> = (1..=n).map(f64::from).collect();
            let median = Estimate::median(&values).expect("values");
            let high = f64::from(n) + 1.0 - low;
            assert_eq!((median.low, median.high), (low, high), "{n}");
        }
    }

    #[test]
    fn a_run_that_never_settled_settles_later_than_any() {
        let values = [3.0, f64::INFINITY, 1.0];
        let median = Estimate::median(&values).expect("finite");
        assert_eq!((median.value, median.n), (3.0, 3));
        assert_eq!(Estimate::median(&[f64::INFINITY]), None);
        assert_eq!(Estimate::median(&[]), None);
        assert_eq!(Estimate::median(&[1.0, 2.0]).expect("two").value, 1.5);
    }

    #[test]
    fn five_values_have_no_interval_and_six_have_their_ends() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0, 6.0];
        let five = Estimate::median(&values[..5]).expect("five");
        assert_eq!((five.value, five.has_interval()), (3.0, false));
        let six = Estimate::median(&values).expect("six");
        assert_eq!((six.value, six.low, six.high), (3.5, 1.0, 6.0));
        // Half of them never reached it: the median is later than the least, and nothing more is known.
        let never = [1.0, 2.0, 3.0].into_iter().chain([f64::INFINITY; 3]);
        let never = Estimate::median_or_never(&never.collect::<Vec<_>>()).expect("six");
        assert_eq!((never.value, never.low), (f64::INFINITY, 1.0));
        assert!(never.has_interval());
    }
}
