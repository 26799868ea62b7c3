//! A point of the grid: one loop over one link, and the plant and law of that loop.

use std::sync::Arc;

use crate::system::{Loop, System, Unfit};
use endpoint::{Outstanding, SampleTime};
use link::Profile;

use super::machine::Machine;
use super::made::Made;

/// What lies between the two ends.
#[derive(Debug, Clone)]
pub enum Between {
    /// A whole link.
    Named(Arc<Profile>),
    /// A link made of numbers.
    Made(Made),
}

impl Between {
    /// The name from which its seeds are derived.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Between::Named(profile) => profile.name(),
            Between::Made(_) => Made::NAME,
        }
    }
}

/// One combination of the axes' levels.
#[derive(Debug, Clone)]
pub struct Point {
    /// The link between the ends.
    pub between: Between,
    /// The client whose timings the controller has.
    pub client: Machine,
    /// The plant with its law.
    pub system: Arc<System>,
    /// Sample time of plant and controller.
    pub h: SampleTime,
    /// Requests that may be under way.
    pub outstanding: Outstanding,
    /// Proportional gain, instead of the system's.
    pub kp: Option<f64>,
    /// Integral gain in 1/s, instead of the system's.
    pub ki: Option<f64>,
}

/// Gains, or a sample time, with which there is no loop.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoLoop {
    /// The law has no such gains.
    #[error("the law of {system} has no kp and ki to replace")]
    Gains {
        /// Name of the system.
        system: String,
    },
    /// The system cannot run at this h.
    #[error(transparent)]
    Unfit(#[from] Unfit),
}

impl Point {
    /// The point's plant and law: those of its system, with the point's gains if it has any.
    ///
    /// # Errors
    /// [`NoLoop`] if its gains or its h make no loop.
    pub fn design(&self) -> Result<Loop, NoLoop> {
        let system = self.system.with_gains(self.kp, self.ki);
        let system = system.ok_or_else(|| NoLoop::Gains {
            system: self.system.name().to_owned(),
        })?;
        Ok(system.at(self.h)?)
    }
}
