//! A running sampled system: its inputs and outputs at each tick, without allocation after
//! construction.

use nalgebra::DMatrix;

use crate::signals::Signals;
use crate::state_space::StateSpace;
use crate::timebase::Discrete;

/// The state of a running system, at rest when new.
///
/// A step costs about n² multiplications; for the motor (n = 2) that is a few nanoseconds. The input
/// is not checked: one that is not finite would stay in the state forever, so reject it earlier.
#[derive(Debug, Clone, PartialEq)]
pub struct Stepper {
    /// The matrix row by row, as made by [`rows`].
    rows: Vec<f64>,
    /// C row by row.
    c: Vec<f64>,
    /// D row by row.
    d: Vec<f64>,
    inputs: usize,
    /// The state in which it began.
    initial: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    /// Inputs within the dead time, the oldest at `oldest`.
    waiting: Vec<Signals>,
    oldest: usize,
}

impl Stepper {
    /// `system` at rest.
    #[must_use]
    pub fn new(system: &StateSpace<Discrete>) -> Self {
        Self::delayed(system, 0)
    }

    /// `system` at rest, behind a dead time of `delay_ticks` ticks.
    #[must_use]
    pub fn delayed(system: &StateSpace<Discrete>, delay_ticks: usize) -> Self {
        let n = system.order();
        Self {
            rows: rows(system),
            c: row_by_row(system.c()),
            d: row_by_row(system.d()),
            inputs: system.inputs(),
            initial: vec![0.0; n],
            state: vec![0.0; n],
            next: vec![0.0; n],
            waiting: vec![Signals::zeros(system.inputs()); delay_ticks],
            oldest: 0,
        }
    }

    /// One tick with inputs `u`; returns the outputs of the same tick. Of one input too few, the second is 0.
    #[inline]
    pub fn step_all(&mut self, u: Signals) -> Signals {
        if let ([_], 1) = (self.d.as_slice(), self.inputs) {
            return self.step(u.first).into();
        }
        let u = self.delayed_input(u);
        let u = [u.first, u.second.unwrap_or_default()];
        let u = &u[..self.inputs];
        let n = self.state.len();
        let output = |k: usize| {
            let (c, d) = (&self.c[k * n..(k + 1) * n], &self.d[k * u.len()..]);
            onto(dot(c, &self.state), d, u)
        };
        let y = Signals {
            first: output(0),
            second: (self.d.len() > u.len()).then(|| output(1)),
        };
        for (next, row) in self
            .next
            .iter_mut()
            .zip(self.rows.chunks_exact(n + u.len()))
        {
            *next = onto(dot(&row[..n], &self.state), &row[n..], u);
        }
        std::mem::swap(&mut self.state, &mut self.next);
        y
    }

    /// The input whose dead time is over, when this one enters.
    #[inline]
    fn delayed_input(&mut self, u: Signals) -> Signals {
        let ticks = self.waiting.len();
        match self.waiting.get_mut(self.oldest) {
            None => u,
            Some(place) => {
                self.oldest = (self.oldest + 1) % ticks;
                // The newest input takes the place of the oldest.
                std::mem::replace(place, u)
            }
        }
    }

    /// One tick of a system with one input and one output: with input `u`; returns the output of the same
    /// tick.
    #[inline]
    pub fn step(&mut self, u: f64) -> f64 {
        let u = self.delayed_input(u.into()).first;
        let d = self.d.first().copied().unwrap_or_default();
        // Two states, as most plants have, without a loop: the same sums in the same order.
        if let ([x0, x1], [c0, c1], [a00, a01, b0, a10, a11, b1], [next0, next1]) = (
            self.state.as_slice(),
            self.c.as_slice(),
            self.rows.as_slice(),
            self.next.as_mut_slice(),
        ) {
            let y = 0.0 + c0 * x0 + c1 * x1 + d * u;
            *next0 = 0.0 + a00 * x0 + a01 * x1 + b0 * u;
            *next1 = 0.0 + a10 * x0 + a11 * x1 + b1 * u;
            std::mem::swap(&mut self.state, &mut self.next);
            return y;
        }
        let y = dot(&self.c, &self.state) + d * u;
        let n = self.state.len();
        for (next, row) in self.next.iter_mut().zip(self.rows.chunks_exact(n + 1)) {
            *next = dot(&row[..n], &self.state) + row[n] * u;
        }
        std::mem::swap(&mut self.state, &mut self.next);
        y
    }

    /// The same in the state `x0`; missing states are 0.
    #[must_use]
    pub fn from_state(mut self, x0: &[f64]) -> Self {
        self.state.fill(0.0);
        for (state, x) in self.state.iter_mut().zip(x0) {
            *state = *x;
        }
        self.initial.clone_from(&self.state);
        self
    }

    /// The outputs of the present state, for no input.
    #[must_use]
    pub fn output(&self) -> Signals {
        let n = self.state.len();
        let of = |k: usize| dot(&self.c[k * n..(k + 1) * n], &self.state);
        Signals {
            first: of(0),
            second: (self.d.len() > self.inputs).then(|| of(1)),
        }
    }

    /// The number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Returns to the state in which it began: to rest, unless [`Stepper::from_state`] gave another.
    pub fn reset(&mut self) {
        self.state.clone_from(&self.initial);
        self.waiting.fill(Signals::zeros(self.inputs));
    }

    /// Whether every state is a finite number.
    pub(crate) fn is_finite(&self) -> bool {
        self.state.iter().all(|x| x.is_finite())
    }

    /// Undoes the last step of a system without dead time: only once, directly after the step.
    pub(crate) fn undo(&mut self) {
        std::mem::swap(&mut self.state, &mut self.next);
    }
}

/// One row per state: its row of A, then its row of B.
pub(crate) fn rows(system: &StateSpace<Discrete>) -> Vec<f64> {
    let n = system.order();
    let mut rows = Vec::with_capacity(n * (n + system.inputs()));
    for row in 0..n {
        rows.extend(system.a().row(row).iter());
        rows.extend(system.b().row(row).iter());
    }
    rows
}

/// The entries of a matrix, row by row.
pub(crate) fn row_by_row(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}

/// A sum, and what each input adds to it, from left to right.
#[inline]
pub(crate) fn onto(sum: f64, gains: &[f64], u: &[f64]) -> f64 {
    gains
        .iter()
        .zip(u)
        .fold(sum, |sum, (gain, u)| sum + gain * u)
}

/// Summed from left to right, beginning with 0, so that other languages get the same bits.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
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
        let mut moving = Stepper::new(&sampled).from_state(&[2.0]);
        let first = moving.step(0.0);
        assert!(moving.step(f64::INFINITY).is_infinite());
        moving.reset();
        assert_eq!(moving.step(0.0), first);
    }

    #[test]
    fn a_dead_time_shows_the_same_output_that_many_ticks_later() {
        let lag = TransferFunction::try_new([1.0], [1.0, 2.0], Continuous).expect("valid");
        let sampled =
            discretise(&StateSpace::from(&lag), Method::ZeroOrderHold, 0.1).expect("regular");
        let inputs = [1.0, -0.5, 2.0, 0.0, 0.0, 3.0, 1.0];
        let mut at_once = Stepper::new(&sampled);
        let mut later = Stepper::delayed(&sampled, 3);
        let prompt: Vec<f64> = inputs.iter().map(|u| at_once.step(*u)).collect();
        let delayed: Vec<f64> = inputs.iter().map(|u| later.step(*u)).collect();
        assert_eq!(delayed[..3], [0.0; 3]);
        assert_eq!(delayed[3..], prompt[..4]);
    }
}
