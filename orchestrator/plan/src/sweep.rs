//! A sweep: a loop over a grid of conditions and settings, in virtual time, as an experiment has it in place of cells.
//!
//! - `table` is the table `[sweep]` as written, [`SweepText`] what a plan keeps of it. `reading` checks its words, and
//!   makes the [`Grid`] of [`Axis`]es of them. `old` writes files of before sweeps were experiments as they are now.
//! - [`Sweep`] is the result. A [`Point`] of its grid has a loop and a link (`made`: one from numbers), [`Machine`] the
//!   timings of both ends.
//!
//! What runs come to, and what is found in it, is elsewhere.

pub(crate) mod axis;
mod grid;
mod machine;
mod made;
mod number;
pub(crate) mod old;
mod point;
pub(crate) mod reading;
pub(crate) mod table;
mod text;

pub use axis::{Axis, UnknownAxis};
pub use grid::{Dimension, Grid, Level};
pub use machine::{Machine, UnknownMachine};
pub use made::{Made, Unplayable};
pub use number::brief;
pub use old::renewed;
pub use point::{Between, NoLoop, Point};
pub use text::SweepText;

use crate::seed::link_seed;

/// A sweep.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Short name.
    pub name: String,
    /// The question that it answers.
    pub about: String,
    /// How long the controller sends, in virtual time.
    pub duration_ns: u64,
    /// How often each point is run.
    pub repeats: u32,
    /// The seed that all others are derived from.
    pub seed: u64,
    /// Cost of a squared command relative to a squared error.
    pub rho: f64,
    /// The points to run.
    pub grid: Grid,
}

/// One run of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    /// The point's number.
    pub point: usize,
    /// Number of the repeat, from 1.
    pub repeat: u32,
}

impl Sweep {
    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.grid.points().saturating_mul(self.repeats as usize)
    }

    /// The run with this number; the repeats of a point follow each other.
    #[must_use]
    pub fn run(&self, number: usize) -> Run {
        let repeats = self.repeats as usize;
        Run {
            point: number / repeats,
            // Less than `repeats`, which is a u32.
            repeat: u32::try_from(number % repeats).unwrap_or(u32::MAX - 1) + 1,
        }
    }

    /// A run's number.
    #[must_use]
    pub fn number(&self, run: Run) -> usize {
        run.point * self.repeats as usize + run.repeat as usize - 1
    }

    /// The seed of a point's link, derived as in `webloop run` from the link's name and the repeat only. So
    /// points can be compared in pairs, and a point over a whole link equals the cell of a run.
    #[must_use]
    pub fn link_seed(&self, point: &Point, repeat: u32) -> u64 {
        link_seed(self.seed, point.between.name(), repeat)
    }
}
