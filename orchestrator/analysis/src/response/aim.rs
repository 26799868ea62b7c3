//! What a run was to do, and when.

use endpoint::Reference;
use plan::system::Band;

use crate::asked::{Asked, Task};

/// What a run was to do, and when: what its ticks are judged by.
#[derive(Debug, Clone, PartialEq)]
pub struct Aim {
    /// The sample time, ns.
    pub h_ns: u64,
    /// The controller's first deadline, on the clock of the rows, ns; `None` for the tick that takes the first
    /// command, where rows are all that there is.
    pub start_ns: Option<u64>,
    /// How long the run was to last, ns; `None` for until its last tick.
    pub duration_ns: Option<u64>,
    /// The reference; at the start, if it moves.
    pub r: f64,
    /// The changes of a reference that moves.
    pub reference: Option<Reference>,
    /// The output at the start; 0 at rest. `None` for the first of the ticks: a program alone knows where its plant
    /// begins.
    pub y0: Option<f64>,
    /// What is asked of the first output.
    pub first: Asked,
    /// What is asked of the second output.
    pub second: Asked,
    /// The reference of the second output, if it has one.
    pub second_r: Option<f64>,
}

impl Aim {
    /// A step to 1 from rest, over all ticks.
    #[must_use]
    pub fn step(h_ns: u64) -> Aim {
        Aim {
            h_ns,
            start_ns: None,
            duration_ns: None,
            r: 1.0,
            reference: None,
            y0: Some(0.0),
            first: Asked::default(),
            second: Asked::default(),
            second_r: None,
        }
    }
    /// What the loop is for: a reference that rests at 0, or within the band of where y begins, asks y to be
    /// where it is. `step` is how far r is from where y was before.
    pub(super) fn task(&self, step: f64) -> Task {
        let rests = self.reference.is_none();
        let is_there = match self.first.band {
            Some(Band::Absolute(band)) => step.abs() <= band,
            _ => step == 0.0,
        };
        if rests && (self.r == 0.0 || is_there) {
            Task::Regulation
        } else {
            Task::Tracking
        }
    }

    /// The reference at a sample.
    pub(super) fn r_at(&self, k: usize) -> f64 {
        let moving = self.reference.as_ref();
        moving.map_or(self.r, |moving| moving.at(self.t_ns(k)))
    }

    /// The first sample of the last step among the samples `y`, of which there is one, and r before it. Without
    /// a change of r it is the start, from the plant's first output.
    pub(super) fn last_step(&self, y: &[f64]) -> (usize, f64) {
        let moving = self.reference.as_ref();
        let change = moving.and_then(|moving| moving.last_change(self.t_ns(y.len() - 1)));
        let y0 = self.y0.or(y.first().copied());
        change.map_or((0, y0.unwrap_or_default()), |(t_ns, before)| {
            (t_ns.div_ceil(self.h_ns) as usize, before)
        })
    }

    fn t_ns(&self, k: usize) -> u64 {
        (k as u64).saturating_mul(self.h_ns)
    }
}
