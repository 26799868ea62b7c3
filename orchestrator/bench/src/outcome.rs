//! What the repetitions came to.

use analysis::statistics::median;

use crate::comparison::Goal;
use crate::contender::{Contender, Lack, Measured};
use crate::group::Group;

/// One contender's figures, repetition by repetition.
#[derive(Debug)]
pub(crate) struct Series {
    /// Whose they are.
    pub(crate) contender: &'static Contender,
    /// Those of each repetition that was measured, with its number.
    times: Vec<(u32, Measured)>,
    /// Number of repetitions tried.
    tried: u32,
    lack: Option<Lack>,
}

impl Series {
    pub(crate) fn new(contender: &'static Contender) -> Series {
        Series {
            contender,
            times: Vec::new(),
            tried: 0,
            lack: None,
        }
    }

    /// What the next repetition came to.
    pub(crate) fn add(&mut self, measured: Result<Measured, Lack>) {
        match measured {
            Ok(figures) => self.times.push((self.tried, figures)),
            Err(lack) => self.lack = Some(lack),
        }
        self.tried += 1;
    }

    /// Whether it could not be measured at all, so that it is not tried again.
    pub(crate) fn is_skipped(&self) -> bool {
        self.times.is_empty() && self.lack.is_some()
    }

    /// Why it was not measured, or not each time.
    pub(crate) fn lack(&self) -> Option<&str> {
        self.lack.as_ref().map(|lack| lack.0.as_str())
    }

    /// The names of its figures.
    pub(crate) fn figures(&self) -> Vec<&'static str> {
        let first = self.times.first();
        first.map_or_else(Vec::new, |(_, figures)| {
            figures.iter().map(|(name, _)| *name).collect()
        })
    }

    /// A figure's values with the numbers of their repetitions.
    pub(crate) fn values<'a>(&'a self, figure: &'a str) -> impl Iterator<Item = (u32, f64)> + 'a {
        self.times.iter().filter_map(move |(time, figures)| {
            let found = figures.iter().find(|(name, _)| *name == figure)?;
            Some((*time, found.1))
        })
    }

    /// The median of a figure.
    pub(crate) fn median(&self, figure: &str) -> Option<f64> {
        let values: Vec<f64> = self.values(figure).map(|(_, value)| value).collect();
        median(&values)
    }

    /// A figure as a multiple of another contender's.
    pub(crate) fn ratio(&self, figure: &str, base: &Series) -> Option<Ratio> {
        let mut ratios: Vec<f64> = self
            .values(figure)
            .filter_map(|(time, value)| {
                let found = base.values(figure).find(|(at, _)| *at == time)?;
                Some(value / found.1)
            })
            .collect();
        ratios.sort_unstable_by(f64::total_cmp);
        Some(Ratio {
            median: median(&ratios)?,
            least: *ratios.first()?,
            most: *ratios.last()?,
        })
    }
}

/// A ratio of two figures, each of one repetition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ratio {
    /// The median of the repetitions.
    pub(crate) median: f64,
    /// The least of them.
    pub(crate) least: f64,
    /// The greatest.
    pub(crate) most: f64,
}

/// A measured table.
#[derive(Debug)]
pub(crate) struct MeasuredTable {
    /// Which one.
    pub(crate) group: Group,
    /// Its contenders, in order.
    pub(crate) series: Vec<Series>,
}

impl MeasuredTable {
    /// The series of a contender.
    pub(crate) fn of(&self, contender: &str) -> Option<&Series> {
        self.series
            .iter()
            .find(|series| series.contender.name == contender)
    }

    /// What a goal came to; `None` if it was not measured.
    pub(crate) fn reached(&self, goal: &Goal) -> Option<f64> {
        let own = self.of(goal.contender)?;
        match goal.times {
            None => own.median(goal.figure),
            Some(base) => Some(own.ratio(goal.figure, self.of(base)?)?.median),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contender::Standing;

    static ONE: Contender = Contender {
        name: "one",
        kind: Standing::Limit,
        measure: |_| Ok(Vec::new()),
    };

    fn series(values: &[Option<f64>]) -> Series {
        let mut series = Series::new(&ONE);
        for value in values {
            let measured = value.map(|value| vec![("p50_us", value)]);
            series.add(measured.ok_or_else(|| Lack("gone".to_owned())));
        }
        series
    }

    #[test]
    fn a_ratio_is_taken_within_a_repetition() {
        // Twice as much each time, on a machine whose speed changes.
        let (base, own) = (
            series(&[Some(1.0), Some(10.0), Some(3.0)]),
            series(&[Some(2.0), Some(20.0), Some(6.0)]),
        );
        let ratio = own.ratio("p50_us", &base).expect("three ratios");
        assert_eq!((ratio.least, ratio.median, ratio.most), (2.0, 2.0, 2.0));
    }

    #[test]
    fn a_repetition_that_lacks_one_of_both_has_no_ratio() {
        let (base, own) = (
            series(&[Some(1.0), None, Some(4.0)]),
            series(&[Some(3.0), Some(9.0), None]),
        );
        let ratio = own.ratio("p50_us", &base).expect("one ratio");
        assert_eq!((ratio.least, ratio.median, ratio.most), (3.0, 3.0, 3.0));
        assert!(!own.is_skipped());
    }

    #[test]
    fn what_could_not_be_measured_at_first_is_skipped() {
        let own = series(&[None]);
        assert!(own.is_skipped());
        assert_eq!(own.lack(), Some("gone"));
        assert!(own.ratio("p50_us", &series(&[Some(1.0)])).is_none());
    }
}
