//! What a sweep finds by itself: pairs of axes whose effects do not simply add up.
//!
//! The first level of an axis is its baseline; each other level multiplies the settling time by a ratio. If
//! that ratio at some level of another axis differs from the ratio at that axis's first level, the two axes
//! interact; the more it changes, the greater the finding. No pairs are chosen in advance.

use std::fmt;

use crate::layout::digits;

use super::runs::{Measure, PointRuns, middle};
use plan::sweep::{Axis, Dimension, Sweep};

/// Axes with more levels are for maps: each of their levels is a small step.
const LEVELS_MAX: usize = 12;
/// A ratio that changes by less than this factor is not a finding.
const FACTOR: f64 = 1.25;
/// Most findings printed: in total, and for one pair of axes.
const TOLD: usize = 4;
const OF_A_PAIR: usize = 2;

/// The effect of one level, changed by another axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The axis that has the effect.
    pub axis: Axis,
    /// The level that has the effect.
    pub level: String,
    /// The level that it is compared with: the first of the axis.
    pub baseline: String,
    /// The axis that changes the effect.
    pub by: Axis,
    /// The level of that axis at which the effect changes most.
    pub at: String,
    /// The first level of that axis, for comparison.
    pub home: String,
    /// Settling at `level` over settling at `baseline`, both at `at`; infinite if it does not settle.
    pub ratio: f64,
    /// The same ratio at `home`.
    pub at_home: f64,
}

impl Finding {
    /// The factor by which the ratio changes, at least 1 in either direction.
    #[must_use]
    pub fn factor(&self) -> f64 {
        let factor = self.ratio / self.at_home;
        factor.max(factor.recip())
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let there = capital(&self.by.say(&self.at));
        let (level, baseline) = (self.axis.say(&self.level), self.axis.say(&self.baseline));
        if self.ratio.is_finite() {
            write!(
                f,
                "{there} the step settles {} times as late {level} as {baseline}",
                digits(Some(self.ratio))
            )?;
        } else {
            write!(
                f,
                "{there} the step does not settle {level}, though it does {baseline}"
            )?;
        }
        let home = self.by.say(&self.home);
        write!(f, "; {home} {} times as late.", digits(Some(self.at_home)))
    }
}

/// The findings, greatest first.
#[must_use]
pub fn findings(sweep: &Sweep, points: &[PointRuns]) -> Vec<Finding> {
    let dimensions = sweep.grid.dimensions();
    let is_few = |d: &&Dimension<'_>| (2..=LEVELS_MAX).contains(&d.levels.len());
    let few: Vec<&Dimension<'_>> = dimensions.iter().filter(is_few).collect();
    let mut told: Vec<Finding> = Vec::new();
    for (first, one) in few.iter().enumerate() {
        for other in &few[first + 1..] {
            // The factor is the same whichever axis of the pair is the cause; a sentence reads better
            // if a named axis is the one whose effect changes.
            let (axis, by) = if one.axis.is_ordered() && !other.axis.is_ordered() {
                (other, one)
            } else {
                (one, other)
            };
            let settling = Settling::of(sweep, points, axis, by);
            let levels = 1..axis.levels.len();
            let mut found: Vec<Finding> = levels
                .filter_map(|level| settling.departure(axis, level, by))
                .filter(|finding| finding.factor() >= FACTOR)
                .collect();
            found.sort_by(|a, b| b.factor().total_cmp(&a.factor()));
            told.extend(found.into_iter().take(OF_A_PAIR));
        }
    }
    told.sort_by(|a, b| b.factor().total_cmp(&a.factor()));
    told.truncate(TOLD);
    told
}

/// The median settling at each pair of levels, over all other axes.
struct Settling(Vec<Vec<f64>>);

impl Settling {
    fn of(
        sweep: &Sweep,
        points: &[PointRuns],
        axis: &Dimension<'_>,
        by: &Dimension<'_>,
    ) -> Settling {
        let dimensions = sweep.grid.dimensions();
        let position = |axis| dimensions.iter().position(|d| d.axis == axis).unwrap_or(0);
        let (a, b) = (position(axis.axis), position(by.axis));
        let mut values = vec![vec![Vec::new(); by.levels.len()]; axis.levels.len()];
        for (number, runs) in points.iter().enumerate() {
            let place = sweep.grid.place(number);
            values[place[a]][place[b]].push(runs.figure(Measure::Settling));
        }
        let medians = values
            .into_iter()
            .map(|row| row.iter().map(|values| middle(values)).collect())
            .collect();
        Settling(medians)
    }

    /// Settling at `level` over settling at the first level; `None` if it does not settle at the first.
    fn ratio(&self, level: usize, at: usize) -> Option<f64> {
        let (own, first) = (self.0[level][at], self.0[0][at]);
        (first.is_finite() && first > 0.0).then_some(own / first)
    }

    /// The level of `by` at which the ratio of `level` differs most from the ratio at the first level
    /// of `by`.
    fn departure(&self, axis: &Dimension<'_>, level: usize, by: &Dimension<'_>) -> Option<Finding> {
        let at_home = self.ratio(level, 0).filter(|ratio| ratio.is_finite())?;
        let candidates = (1..by.levels.len()).filter_map(|at| {
            Some(Finding {
                axis: axis.axis,
                level: axis.levels[level].text.clone(),
                baseline: axis.levels[0].text.clone(),
                by: by.axis,
                at: by.levels[at].text.clone(),
                home: by.levels[0].text.clone(),
                ratio: self.ratio(level, at)?,
                at_home,
            })
        });
        candidates.max_by(|a, b| a.factor().total_cmp(&b.factor()))
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}
