//! A sweep: its grid, how each point is run, and which link each run meets.

use sha2::{Digest, Sha256};

use crate::axis::Axis;
use crate::grid::Grid;
use crate::point::Point;

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

/// What the caller sets in place of the file's values.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Instead {
    /// The seed, if it is replaced.
    pub seed: Option<u64>,
    /// Axes that are fixed to one value.
    pub fixed: Vec<(Axis, String)>,
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
        plan::link_seed(self.seed, point.between.name(), repeat)
    }
}

/// SHA-256 of a text, in hex: texts with the same checksum are the same.
#[must_use]
pub fn checksum(text: &str) -> String {
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
