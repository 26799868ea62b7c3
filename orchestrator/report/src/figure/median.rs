//! Repeated step responses: the median instant by instant with the quartiles about it, and single runs.

use std::collections::BTreeMap;

use analysis::statistics::quantile_of_sorted;
use analysis::{Run, trace};
use chart::{Mark, Series};
use record::ReadError;

use crate::group::Group;
use crate::tone::OTHER_TONE;

/// Which signal of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// The plant's output.
    Y,
    /// The plant's input.
    U,
}

/// The responses that have been read, by the id of the cell, since panels share their references.
#[derive(Default)]
pub struct Traces(BTreeMap<String, Traced>);

/// A response, as far as it is known.
struct Traced {
    response: trace::Response,
    /// It has no more ticks than this, or only its first ones.
    most: usize,
}

impl Traces {
    /// With the response of a run whose rows have been read already, if there is one.
    #[must_use]
    pub(crate) fn with(known: Option<(&Run, &trace::Response)>) -> Traces {
        let known = known.map(|(run, response)| {
            let response = response.clone();
            let most = usize::MAX;
            (run.cell.id.clone(), Traced { response, most })
        });
        Traces(known.into_iter().collect())
    }

    /// A signal of a run, at its first ticks, so many at least.
    fn of(&mut self, run: &Run, signal: Signal, most: usize) -> Result<&[f64], ReadError> {
        let id = &run.cell.id;
        if self.0.get(id).is_none_or(|known| known.most < most) {
            let response = trace::response(&run.folder, &run.lasts_ns(), most)?;
            self.0.insert(id.clone(), Traced { response, most });
        }
        Ok(self.0.get(id).map_or(&[], |known| match signal {
            Signal::Y => &known.response.y,
            Signal::U => &known.response.u,
        }))
    }

    /// The median of a group's responses with its quartiles, up to `end_s` but no further than the
    /// shortest response. The caller sets the name and the colour.
    ///
    /// # Errors
    /// [`ReadError`] if `ticks.csv` of a run cannot be read.
    pub fn median(
        &mut self,
        group: &Group<'_>,
        signal: Signal,
        h_ns: u64,
        end_s: f64,
    ) -> Result<Series, ReadError> {
        let samples = samples(end_s, h_ns);
        let mut at: Vec<Vec<f64>> = Vec::new();
        for (n, run) in group.runs.iter().enumerate() {
            let values = self.of(run, signal, samples)?;
            let length = values.len().min(samples);
            if n == 0 {
                at.resize(length, Vec::new());
            }
            at.truncate(length);
            for (values, value) in at.iter_mut().zip(values) {
                values.push(*value);
            }
        }
        let middles: Vec<(f64, f64, f64)> = at.into_iter().filter_map(quartiles).collect();
        Ok(Series {
            name: String::new(),
            mark: Mark::Line,
            tone: OTHER_TONE,
            points: seconds(h_ns)
                .zip(middles.iter().map(|(_, y, _)| *y))
                .collect(),
            band: middles.iter().map(|(low, _, high)| (*low, *high)).collect(),
        })
    }

    /// One run's response, up to `end_s`. The caller sets the name and the colour.
    ///
    /// # Errors
    /// [`ReadError`] if `ticks.csv` of the run cannot be read.
    pub fn single(
        &mut self,
        run: &Run,
        signal: Signal,
        h_ns: u64,
        end_s: f64,
    ) -> Result<Series, ReadError> {
        let samples = samples(end_s, h_ns);
        let values = self.of(run, signal, samples)?.iter().copied();
        let points = seconds(h_ns).zip(values).take(samples);
        let points = points.collect();
        Ok(Series::new(String::new(), Mark::Line, OTHER_TONE, points))
    }
}

fn samples(end_s: f64, h_ns: u64) -> usize {
    (end_s * 1e9 / h_ns as f64) as usize + 1
}

fn seconds(h_ns: u64) -> impl Iterator<Item = f64> {
    (0..).map(move |n: u64| (n * h_ns) as f64 / 1e9)
}

/// The lower quartile, the median and the upper quartile: at least half of the values are from one
/// quartile to the other. `None` without values.
fn quartiles(mut values: Vec<f64>) -> Option<(f64, f64, f64)> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let at = |rank: usize| values.get(rank).copied();
    // Between opposite infinities there is none, and the line has a gap.
    let middle = quantile_of_sorted(&values, 0.5).unwrap_or(f64::NAN);
    Some((at(last / 4)?, middle, at(last - last / 4)?))
}
#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quartiles_of_few_values_are_their_ends() {
        assert_eq!(quartiles(vec![]), None);
        assert_eq!(quartiles(vec![2.0]), Some((2.0, 2.0, 2.0)));
        assert_eq!(quartiles(vec![3.0, 1.0]), Some((1.0, 2.0, 3.0)));
        let five = vec![5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!(quartiles(five), Some((2.0, 3.0, 4.0)));
    }

    proptest! {
        #[test]
        fn at_least_half_of_the_values_lie_between_the_quartiles(
            values in prop::collection::vec(-1e3f64..1e3, 1..50),
        ) {
            let (low, middle, high) = quartiles(values.clone()).expect("not empty");
            prop_assert!(low <= middle && middle <= high);
            let within = values.iter().filter(|y| (low..=high).contains(*y)).count();
            prop_assert!(2 * within >= values.len());
        }
    }
}
