//! What a sweep finds by itself: where two of its axes do not simply add up.
//!
//! An axis's first level is the one its others are held against. Each other level makes the step
//! settle so many times as late; where that number is another at another axis's levels than at its
//! first, the two axes act on each other, and the more the number changes the greater the finding.
//! Nothing is said of which axes these may be.

use std::fmt;

use analysis::layout::digits;

use crate::axis::Axis;
use crate::cell::{Cell, Measure, middle};
use crate::grid::Dimension;
use crate::sweep::Sweep;

/// Axes of more levels are for maps: there each level is a small step.
const LEVELS_MAX: usize = 12;
/// A ratio that changes by less than this factor is not a finding.
const FACTOR: f64 = 1.25;
/// The most findings printed, in all and for one pair of axes.
const TOLD: usize = 4;
const OF_A_PAIR: usize = 2;

/// One level's effect, which another axis changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The axis whose effect it is.
    pub axis: Axis,
    /// Of which level.
    pub level: String,
    /// Against which: the first of the axis.
    pub baseline: String,
    /// What changes it.
    pub by: Axis,
    /// At which of its levels most.
    pub at: String,
    /// Against which: the first of that axis.
    pub home: String,
    /// Settling there over settling at the baseline; infinite if it does not settle.
    pub ratio: f64,
    /// And at home.
    pub at_home: f64,
}

impl Finding {
    /// By which factor it changes, either way.
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

/// The findings, the greatest first.
#[must_use]
pub fn findings(sweep: &Sweep, cells: &[Cell]) -> Vec<Finding> {
    let dimensions = sweep.grid.dimensions();
    let is_few = |d: &&Dimension<'_>| (2..=LEVELS_MAX).contains(&d.levels.len());
    let few: Vec<&Dimension<'_>> = dimensions.iter().filter(is_few).collect();
    let mut told: Vec<Finding> = Vec::new();
    for (first, one) in few.iter().enumerate() {
        for other in &few[first + 1..] {
            // Whichever of two is held against the other, the factor is the same; a name reads
            // better as the one whose effect it is.
            let (axis, by) = if one.axis.is_ordered() && !other.axis.is_ordered() {
                (other, one)
            } else {
                (one, other)
            };
            let settling = Settling::of(sweep, cells, axis, by);
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

/// The median settling at each pair of levels, over everything else.
struct Settling(Vec<Vec<f64>>);

impl Settling {
    fn of(sweep: &Sweep, cells: &[Cell], axis: &Dimension<'_>, by: &Dimension<'_>) -> Settling {
        let dimensions = sweep.grid.dimensions();
        let position = |axis| dimensions.iter().position(|d| d.axis == axis).unwrap_or(0);
        let (a, b) = (position(axis.axis), position(by.axis));
        let mut values = vec![vec![Vec::new(); by.levels.len()]; axis.levels.len()];
        for (number, cell) in cells.iter().enumerate() {
            let place = sweep.grid.place(number);
            values[place[a]][place[b]].push(cell.figure(Measure::Settling));
        }
        let medians = values
            .into_iter()
            .map(|row| row.iter().map(|values| middle(values)).collect())
            .collect();
        Settling(medians)
    }

    /// How many times as late as at the first level the step settles at `level`; `None` where it
    /// does not settle at the first.
    fn ratio(&self, level: usize, at: usize) -> Option<f64> {
        let (own, first) = (self.0[level][at], self.0[0][at]);
        (first.is_finite() && first > 0.0).then_some(own / first)
    }

    /// Where along `by` a level's ratio is farthest from what it is at the first of them.
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
