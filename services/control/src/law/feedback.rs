//! State feedback with a Kalman filter that estimates the state from a late output.
//!
//! The output that a controller has at an update is some ticks old (see
//! [`crate::closed_loop::loop_delay_ticks`]). The filter's model is therefore the plant followed by a
//! delay line of its last outputs: the filter corrects all of them by the oldest, and the gains act
//! on the plant's present state. An update corrects, acts, and predicts, in this order (R. E. Kalman,
//! 1960). There is no integral, so a load that the model does not include leaves an offset.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::{InvalidLaw, limited};
use crate::pid::Saturation;
use crate::riccati;
use crate::state_space::StateSpace;
use crate::stepper::{dot, rows};
use crate::timebase::Discrete;

/// Weights of an optimal regulator, which minimises the sum of output y² + input u².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// The weight of y².
    pub output: f64,
    /// The weight of u², more than zero.
    pub input: f64,
}

/// The noise that a Kalman filter assumes, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator {
    /// Standard deviation of a white disturbance at the plant's input.
    pub disturbance: f64,
    /// Standard deviation of white noise on the output, more than zero.
    pub noise: f64,
}

/// u = reference r - gains x, with x estimated by the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct StateFeedback {
    model: StateSpace<Discrete>,
    /// The matrix row by row, as made by [`rows`].
    rows: Vec<f64>,
    c: Vec<f64>,
    gains: Vec<f64>,
    observer: Vec<f64>,
    reference: f64,
    limits: Option<Saturation>,
    /// The states, then the delay line of outputs, newest first.
    state: Vec<f64>,
    next: Vec<f64>,
    output: f64,
}

impl Weights {
    /// The gains of the optimal regulator, one per state.
    ///
    /// # Errors
    /// [`InvalidLaw::Riccati`] if there is no solution.
    pub fn gains(&self, model: &StateSpace<Discrete>) -> Result<Vec<f64>, InvalidLaw> {
        let b = column(model.b());
        let q = model.c().transpose() * model.c() * self.output;
        let x = riccati::solve(model.a(), &b, &q, self.input)?;
        let scale = self.input + (b.transpose() * &x * &b)[0];
        Ok((b.transpose() * &x * model.a() / scale)
            .iter()
            .copied()
            .collect())
    }
}

impl Estimator {
    /// The steady filter's gains for an output that is `delay` ticks old, at least one: first for the
    /// states, then for the delay line.
    ///
    /// # Errors
    /// [`InvalidLaw::Riccati`] if there is no solution.
    pub fn observer(
        &self,
        model: &StateSpace<Discrete>,
        delay: usize,
    ) -> Result<Vec<f64>, InvalidLaw> {
        let (n, tau) = (model.order(), delay.max(1));
        let (a, b) = with_line(model, tau);
        let c = last_of(n + tau);
        let q = &b * b.transpose() * self.disturbance.powi(2);
        let r = self.noise.powi(2);
        let p = riccati::solve(&a.transpose(), &c.transpose(), &q, r)?;
        let scale = (&c * &p * c.transpose())[0] + r;
        Ok((p * c.transpose() / scale).iter().copied().collect())
    }
}

impl StateFeedback {
    /// A law at rest: `gains` for the model's n states, `observer` for these and the delay line.
    /// `None` leaves the command unlimited.
    ///
    /// The reference is scaled so that a plant equal to the model rests at it.
    ///
    /// # Errors
    /// [`InvalidLaw`] if lengths do not match, a number is not finite, the range of the limits is
    /// empty, or no constant command holds the output at a reference.
    pub fn try_new(
        model: StateSpace<Discrete>,
        gains: Vec<f64>,
        observer: Vec<f64>,
        limits: Option<Saturation>,
    ) -> Result<Self, InvalidLaw> {
        limits.as_ref().map_or(Ok(()), Saturation::check)?;
        let n = model.order();
        if gains.len() != n {
            return Err(InvalidLaw::Length {
                list: "gains",
                given: gains.len(),
                needed: n,
                why: "one for each state of the sampled model",
            });
        }
        if observer.len() <= n {
            return Err(InvalidLaw::Length {
                list: "observer",
                given: observer.len(),
                needed: n + 1,
                why: "or more: one for each state, and one for each tick that the output is old",
            });
        }
        for (field, list) in [("gains", &gains), ("observer", &observer)] {
            if !list.iter().all(|x| x.is_finite()) {
                return Err(InvalidLaw::NotFinite { field });
            }
        }
        let reference = reference(&model, &gains).ok_or(InvalidLaw::NoRest)?;
        Ok(Self {
            rows: rows(&model),
            c: model.c().iter().copied().collect(),
            state: vec![0.0; observer.len()],
            next: vec![0.0; observer.len()],
            model,
            gains,
            observer,
            reference,
            limits,
            output: 0.0,
        })
    }

    /// The factor of the reference.
    #[must_use]
    pub fn reference(&self) -> f64 {
        self.reference
    }

    /// Number of the plant's states and of the delay line's outputs.
    pub(super) fn order(&self) -> usize {
        self.observer.len()
    }

    pub(super) fn update(&mut self, r: f64, y: f64) -> f64 {
        if !(r.is_finite() && y.is_finite()) {
            return self.output;
        }
        let n = self.gains.len();
        let Some(&expected) = self.state.last() else {
            return self.output;
        };
        let innovation = y - expected;
        for ((next, state), gain) in self.next.iter_mut().zip(&self.state).zip(&self.observer) {
            *next = state + gain * innovation;
        }
        // `next` has the corrected state; `state` gets the predicted one.
        let (x, line) = self.next.split_at(n);
        let wanted = self.reference * r - dot(&self.gains, x);
        let u = limited(wanted, self.limits.as_ref());
        let o = dot(&self.c, x) + self.model.d() * u;
        let rows = self.rows.chunks_exact(n + 1);
        let predicted = rows.map(|row| dot(&row[..n], x) + row[n] * u);
        let is_finite = u.is_finite()
            && o.is_finite()
            && line.iter().all(|x| x.is_finite())
            && predicted.clone().all(f64::is_finite);
        if !is_finite {
            return self.output;
        }
        for (state, x) in self.state.iter_mut().zip(predicted) {
            *state = x;
        }
        self.state[n] = o;
        let last = line.len() - 1;
        self.state[n + 1..].copy_from_slice(&line[..last]);
        self.output = u;
        u
    }

    /// From y to u with r = 0. With the observer L, the corrected state is (I - L C) s + L y, and the
    /// next state is (A - B K) times it.
    pub(super) fn state_space(&self) -> StateSpace<Discrete> {
        let (n, all) = (self.gains.len(), self.observer.len());
        let (a, b) = with_line(&self.model, all - n);
        let mut k = RowDVector::zeros(all);
        k.columns_mut(0, n).copy_from_slice(&self.gains);
        let l = DVector::from_column_slice(&self.observer);
        let corrected = DMatrix::identity(all, all) - &l * last_of(all);
        let next = a - b * &k;
        let at_once = -(&k * &l)[0];
        StateSpace::try_new(
            &next * &corrected,
            next * l,
            -k * corrected,
            at_once,
            self.model.timebase(),
        )
        .expect("finite parts in shapes that fit")
    }
}

/// The factor of the reference: u + K x, with u and x at rest for an output of 1.
fn reference(model: &StateSpace<Discrete>, gains: &[f64]) -> Option<f64> {
    let n = model.order();
    let mut rest = DMatrix::zeros(n + 1, n + 1);
    rest.view_mut((0, 0), (n, n))
        .copy_from(&(model.a() - DMatrix::identity(n, n)));
    rest.view_mut((0, n), (n, 1)).copy_from(model.b());
    rest.view_mut((n, 0), (1, n)).copy_from(model.c());
    rest[(n, n)] = model.d();
    let mut wanted = DVector::zeros(n + 1);
    wanted[n] = 1.0;
    let found = rest.lu().solve(&wanted)?;
    let factor = gains
        .iter()
        .zip(found.iter())
        .fold(found[n], |sum, (k, x)| sum + k * x);
    factor.is_finite().then_some(factor)
}

/// A and B of the model followed by a delay line of `tau` outputs, of which the first is this tick's output.
fn with_line(model: &StateSpace<Discrete>, tau: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = model.order();
    let mut a = DMatrix::zeros(n + tau, n + tau);
    a.view_mut((0, 0), (n, n)).copy_from(model.a());
    a.view_mut((n, 0), (1, n)).copy_from(model.c());
    for i in 1..tau {
        a[(n + i, n + i - 1)] = 1.0;
    }
    let mut b = DMatrix::zeros(n + tau, 1);
    b.view_mut((0, 0), (n, 1)).copy_from(model.b());
    b[n] = model.d();
    (a, b)
}

/// The row vector that selects the last of `n` states.
fn last_of(n: usize) -> DMatrix<f64> {
    let mut c = DMatrix::zeros(1, n);
    c[n - 1] = 1.0;
    c
}

fn column(b: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(b.len(), 1, b.as_slice())
}
