//! Runs that differ only in their repeat, and what they agree on.

use analysis::{Campaign, Run};
use endpoint::Preset;
use plan::Client;
use serde::Serialize;

/// The complete runs of one topology, client, setup, mode and rate, in order of repeat.
#[derive(Debug, Clone)]
pub struct Group<'a> {
    /// The complete runs.
    pub runs: Vec<&'a Run>,
    /// How many there would be if all had been run and were complete.
    pub planned: usize,
}

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked<'a> {
    /// The topology.
    pub topology: &'a str,
    /// The client.
    pub client: Client,
    /// Its preset; only cells with exactly that setup are meant.
    pub preset: Preset,
    /// The mode.
    pub mode: endpoint::Mode,
    /// The sample time, ns.
    pub h_ns: u64,
}

impl<'a> Group<'a> {
    /// The group that is asked for; empty where the plan has none.
    #[must_use]
    pub fn of(campaign: &'a Campaign, asked: Asked<'_>) -> Group<'a> {
        let planned: Vec<&Run> = campaign.runs.iter().filter(|run| asked.is(run)).collect();
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

    /// A figure of each run; a run that has none is infinite, as a step that never settled is.
    #[must_use]
    pub fn values(&self, figure: impl Fn(&Run) -> Option<f64>) -> Vec<f64> {
        let value = |run: &&Run| figure(run).unwrap_or(f64::INFINITY);
        self.runs.iter().map(value).collect()
    }
}

impl Asked<'_> {
    fn is(&self, run: &Run) -> bool {
        let cell = &run.cell;
        cell.topology == self.topology
            && cell.client == self.client
            && cell.preset == self.preset
            && cell.settings.mode == self.mode
            && cell.settings.h.ns() == self.h_ns
            && cell.setup() == self.preset.to_string()
    }
}

/// A figure with the interval that it is known in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The figure itself: a median over runs, or one run's.
    pub value: f64,
    /// The interval's lower end; as `value` where nothing is known of it.
    pub low: f64,
    /// The interval's upper end.
    pub high: f64,
    /// How many runs, or messages, it is over.
    pub n: u64,
}

impl Estimate {
    /// The median of some values with its 95 % interval by order statistics (binomial, exact; with
    /// fewer than six values it is their whole range, which is less than 95 % sure).
    ///
    /// `None` of no values, and where the median itself is infinite.
    #[must_use]
    pub fn median(values: &[f64]) -> Option<Estimate> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let middle = n.checked_sub(1)?;
        let value = f64::midpoint(sorted[middle / 2], sorted[middle.div_ceil(2)]);
        let below = ranks_below(n);
        value.is_finite().then(|| Estimate {
            value,
            low: sorted[below],
            high: sorted[n - 1 - below],
            n: n as u64,
        })
    }
}

/// How many of `n` values lie below the 95 % interval of their median: the largest k for which at
/// most k of n fair coins show heads in at most 2.5 % of throws.
fn ranks_below(n: usize) -> usize {
    // P(X = 0), then each from the one before.
    let mut term = 0.5f64.powi(i32::try_from(n).unwrap_or(i32::MAX));
    let (mut sum, mut k) = (term, 0);
    while k < n {
        term *= (n - k) as f64 / (k + 1) as f64;
        sum += term;
        if sum > 0.025 {
            break;
        }
        k += 1;
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_s_interval_is_the_textbooks() {
        // Tables of the sign test: of 20 values the 6th and the 15th, of 10 the 2nd and the 9th, of 6
        // the extremes; of five there is none, and the extremes are what there is.
        for (n, below) in [(1, 0), (5, 0), (6, 0), (9, 1), (10, 1), (20, 5), (25, 7)] {
            assert_eq!(ranks_below(n), below, "{n}");
        }
    }

    #[test]
    fn a_run_that_never_settled_settles_later_than_any() {
        let values = [3.0, f64::INFINITY, 1.0];
        let median = Estimate::median(&values).expect("finite");
        assert_eq!((median.value, median.low, median.n), (3.0, 1.0, 3));
        assert!(median.high.is_infinite());
        assert_eq!(Estimate::median(&[f64::INFINITY]), None);
        assert_eq!(Estimate::median(&[]), None);
        assert_eq!(Estimate::median(&[1.0, 2.0]).expect("two").value, 1.5);
    }
}
