//! A law given as a transfer function: the error in, the command out.

use super::{InvalidLaw, limited};
use crate::pid::Saturation;
use crate::state_space::StateSpace;
use crate::stepper::Stepper;
use crate::timebase::Discrete;

/// A sampled system from the error to the command.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    system: StateSpace<Discrete>,
    limits: Option<Saturation>,
    stepper: Stepper,
    output: f64,
}

impl Transfer {
    /// The law given by `system`, at rest. `None` leaves the command unlimited.
    ///
    /// # Errors
    /// [`InvalidLaw::Pid`] if the range of the limits is empty.
    pub fn try_new(
        system: StateSpace<Discrete>,
        limits: Option<Saturation>,
    ) -> Result<Self, InvalidLaw> {
        limits.as_ref().map_or(Ok(()), Saturation::check)?;
        Ok(Self {
            stepper: Stepper::new(&system),
            system,
            limits,
            output: 0.0,
        })
    }

    /// The law at rest with its command times `factor`; `None` if a number is not finite then.
    pub(super) fn times(&self, factor: f64) -> Option<Self> {
        let of = &self.system;
        let (a, b, c, d) = (
            of.a().clone(),
            of.b().clone(),
            of.c() * factor,
            of.d() * factor,
        );
        let system = StateSpace::try_new(a, b, c, d, of.timebase()).ok()?;
        Self::try_new(system, self.limits).ok()
    }

    pub(super) fn update(&mut self, r: f64, y: f64) -> f64 {
        if !(r.is_finite() && y.is_finite()) {
            return self.output;
        }
        let u = limited(self.stepper.step(r - y), self.limits.as_ref());
        if u.is_finite() && self.stepper.is_finite() {
            self.output = u;
        } else {
            self.stepper.undo();
        }
        self.output
    }

    /// From y to u with r = 0.
    pub(super) fn state_space(&self) -> StateSpace<Discrete> {
        let system = &self.system;
        StateSpace::try_new(
            system.a().clone(),
            -system.b(),
            system.c().clone(),
            -system.d(),
            system.timebase(),
        )
        .expect("a valid system with another sign")
    }
}
