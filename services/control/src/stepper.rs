//! A sampled system that runs: one input and one output a tick, nothing allocated after
//! construction.

use crate::state_space::StateSpace;
use crate::timebase::Discrete;

/// The state of a running system, at rest when new.
///
/// A step costs about n² multiplications; for the motor (n = 2) that is a few nanoseconds. The
/// input is taken as it comes: one that is not finite stays in the state for ever, so refuse it
/// before it gets here.
#[derive(Debug, Clone, PartialEq)]
pub struct Stepper {
    /// One row per state: its row of A, then its entry of B.
    rows: Vec<f64>,
    c: Vec<f64>,
    d: f64,
    state: Vec<f64>,
    next: Vec<f64>,
}

impl Stepper {
    /// `system` at rest.
    #[must_use]
    pub fn new(system: &StateSpace<Discrete>) -> Self {
        let n = system.order();
        let mut rows = Vec::with_capacity(n * (n + 1));
        for row in 0..n {
            rows.extend(system.a().row(row).iter());
            rows.push(system.b()[row]);
        }
        let c = system.c().iter().copied().collect();
        Self {
            rows,
            c,
            d: system.d(),
            state: vec![0.0; n],
            next: vec![0.0; n],
        }
    }

    /// One tick with input `u`: the output of the same tick.
    #[inline]
    pub fn step(&mut self, u: f64) -> f64 {
        let y = dot(&self.c, &self.state) + self.d * u;
        let n = self.state.len();
        for (next, row) in self.next.iter_mut().zip(self.rows.chunks_exact(n + 1)) {
            *next = dot(&row[..n], &self.state) + row[n] * u;
        }
        std::mem::swap(&mut self.state, &mut self.next);
        y
    }

    /// Back to rest.
    pub fn reset(&mut self) {
        self.state.fill(0.0);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretise::{Method, discretise};
    use crate::timebase::Continuous;
    use crate::transfer::TransferFunction;

    #[test]
    fn an_integrator_by_backward_euler_adds_h_times_the_input_at_once() {
        let integrator = TransferFunction::try_new([1.0], [1.0, 0.0], Continuous).expect("valid");
        let sampled = discretise(&StateSpace::from(&integrator), Method::BackwardEuler, 0.5)
            .expect("regular");
        let mut stepper = Stepper::new(&sampled);
        assert_eq!([1.0, 1.0, -2.0].map(|u| stepper.step(u)), [0.5, 1.0, 0.0]);
        stepper.reset();
        assert_eq!(stepper.step(1.0), 0.5);
    }
}
