//! The median of repeated step responses, instant by instant, with the quartiles about it.

use std::collections::BTreeMap;

use analysis::{ReadError, Run, trace};
use chart::{Mark, Series};

use crate::group::Group;
use crate::tone::OTHER_TONE;

/// The responses that have been read, by the id of the cell, since panels share their references.
#[derive(Default)]
pub struct Traces(BTreeMap<String, Vec<f64>>);

impl Traces {
    fn of(&mut self, run: &Run) -> Result<&[f64], ReadError> {
        let id = &run.cell.id;
        if !self.0.contains_key(id) {
            self.0.insert(id.clone(), trace::response(&run.folder)?);
        }
        Ok(self.0.get(id).map_or(&[], Vec::as_slice))
    }

    /// The median of a group's responses with its quartiles, up to `end_s` but no further than the
    /// shortest response. The caller sets the name and the colour.
    pub fn median(
        &mut self,
        group: &Group<'_>,
        h_ns: u64,
        end_s: f64,
    ) -> Result<Series, ReadError> {
        let samples = (end_s * 1e9 / h_ns as f64) as usize + 1;
        let mut at = vec![Vec::new(); samples];
        for run in &group.runs {
            let y = self.of(run)?;
            at.truncate(y.len());
            for (values, y) in at.iter_mut().zip(y) {
                values.push(*y);
            }
        }
        let middles: Vec<(f64, f64, f64)> = at.into_iter().filter_map(quartiles).collect();
        let seconds = (0..).map(|n: u64| (n * h_ns) as f64 / 1e9);
        Ok(Series {
            name: String::new(),
            mark: Mark::Line,
            tone: OTHER_TONE,
            points: seconds.zip(middles.iter().map(|(_, y, _)| *y)).collect(),
            band: middles.iter().map(|(low, _, high)| (*low, *high)).collect(),
        })
    }
}

/// The lower quartile, the median and the upper quartile: at least half of the values are from one
/// quartile to the other. `None` without values.
fn quartiles(mut values: Vec<f64>) -> Option<(f64, f64, f64)> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let at = |rank: usize| values.get(rank).copied();
    let middle = f64::midpoint(at(last / 2)?, at(last.div_ceil(2))?);
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
