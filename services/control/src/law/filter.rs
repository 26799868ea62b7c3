//! A Kalman filter that is stepped tick by tick, with or without an output: its gain follows from its covariance,
//! which grows while nothing is seen (R. E. Kalman, 1960; with outputs that come at times only, B. Sinopoli et al.,
//! 2004).
//!
//! It is the predictor: a step goes from what is known before a tick to what is known before the next. Its noise is
//! that of [`Estimator`], whose disturbance at an input also reaches the outputs, by D. Sums run from left to right,
//! so that other languages get the same bits.

use nalgebra::DMatrix;

use super::InvalidLaw;
use super::feedback::Estimator;
use crate::signals::Signals;
use crate::state_space::StateSpace;
use crate::stepper::{dot, onto, row_by_row};
use crate::timebase::Discrete;

/// The noise of a filter as covariances, and that of its state when it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Of the state, when outputs were seen at every tick.
    pub covariance: DMatrix<f64>,
    /// What a tick adds to it: B W B', with W the disturbance's.
    pub drift: DMatrix<f64>,
    /// Between that and the outputs' noise: B W D'.
    pub cross: DMatrix<f64>,
    /// Of the outputs' noise: D W D' + V, with V the measurement's.
    pub output: DMatrix<f64>,
}

/// A running filter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filter {
    n: usize,
    m: usize,
    p: usize,
    /// The model's matrices and the noise's, row by row.
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    d: Vec<f64>,
    drift: Vec<f64>,
    cross: Vec<f64>,
    output: Vec<f64>,
    /// The state before the next tick, and its covariance.
    pub(super) state: Vec<f64>,
    covariance: Vec<f64>,
    next: Vec<f64>,
    /// A P, and A P C' + cross, and the gain.
    ahead: Vec<f64>,
    reach: Vec<f64>,
    gain: Vec<f64>,
    kept: Vec<f64>,
}

impl Noise {
    /// Whether its shapes fit a model, and all numbers are finite.
    ///
    /// # Errors
    /// [`InvalidLaw`], which names the matrix.
    pub(super) fn check(&self, model: &StateSpace<Discrete>) -> Result<(), InvalidLaw> {
        let (n, p) = (model.order(), model.outputs());
        for (list, matrix, shape) in [
            ("covariance", &self.covariance, (n, n)),
            ("drift", &self.drift, (n, n)),
            ("cross", &self.cross, (n, p)),
            ("output", &self.output, (p, p)),
        ] {
            if matrix.shape() != shape {
                return Err(InvalidLaw::Length {
                    list,
                    given: matrix.len(),
                    needed: shape.0 * shape.1,
                    why: "a row for each state or output of the sampled model",
                });
            }
            if !matrix.iter().all(|x| x.is_finite()) {
                return Err(InvalidLaw::NotFinite { field: list });
            }
        }
        Ok(())
    }
}

impl Estimator {
    /// The noise as covariances for a sampled model.
    ///
    /// # Errors
    /// As [`Estimator::observer`].
    pub fn noise(&self, model: &StateSpace<Discrete>) -> Result<Noise, InvalidLaw> {
        let variances = |deviations: &[f64]| {
            let squares = deviations.iter().map(|deviation| deviation.powi(2));
            DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(deviations.len(), squares))
        };
        let covariance = self.covariance(model)?;
        let (b, d) = (model.b(), model.d());
        let (w, v) = (variances(&self.disturbance), variances(&self.noise));
        Ok(Noise {
            covariance,
            drift: b * &w * b.transpose(),
            cross: b * &w * d.transpose(),
            output: d * &w * d.transpose() + v,
        })
    }
}

impl Filter {
    /// A filter at rest.
    pub(super) fn new(model: &StateSpace<Discrete>, noise: &Noise) -> Self {
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        Self {
            n,
            m,
            p,
            a: row_by_row(model.a()),
            b: row_by_row(model.b()),
            c: row_by_row(model.c()),
            d: row_by_row(model.d()),
            drift: row_by_row(&noise.drift),
            cross: row_by_row(&noise.cross),
            output: row_by_row(&noise.output),
            state: vec![0.0; n],
            covariance: row_by_row(&noise.covariance),
            next: vec![0.0; n],
            ahead: vec![0.0; n * n],
            reach: vec![0.0; n * p],
            gain: vec![0.0; n * p],
            kept: vec![0.0; n + n * n],
        }
    }

    /// Remembers what it knows, for [`Filter::forget`].
    pub(super) fn keep(&mut self) {
        let (state, covariance) = self.kept.split_at_mut(self.n);
        state.copy_from_slice(&self.state);
        covariance.copy_from_slice(&self.covariance);
    }

    /// Returns to what it knew at the last [`Filter::keep`].
    pub(super) fn forget(&mut self) {
        let (state, covariance) = self.kept.split_at(self.n);
        self.state.copy_from_slice(state);
        self.covariance.copy_from_slice(covariance);
    }

    /// Whether all that it knows is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.state
            .iter()
            .chain(&self.covariance)
            .all(|x| x.is_finite())
    }

    /// A tick with these inputs, whose outputs were seen, or were not.
    pub(super) fn tick(&mut self, u: Signals, y: Option<Signals>) {
        let n = self.n;
        for i in 0..n {
            for j in 0..n {
                // The covariance is symmetric: its columns are its rows.
                let column = &self.covariance[j * n..(j + 1) * n];
                self.ahead[i * n + j] = dot(&self.a[i * n..(i + 1) * n], column);
            }
        }
        let mut innovation = [0.0; Signals::MOST];
        match y {
            None => self.gain.fill(0.0),
            Some(y) => {
                self.weigh();
                innovation = self.innovation(u, y);
            }
        }
        self.step(u);
        for (x, gains) in self.state.iter_mut().zip(self.gain.chunks_exact(self.p)) {
            *x = onto(*x, gains, &innovation[..self.p]);
        }
        self.spread();
    }

    /// Goes a tick on with a state, without its covariance.
    pub(super) fn step(&mut self, u: Signals) {
        let (n, u) = (self.n, [u.first, u.second.unwrap_or_default()]);
        for (i, next) in self.next.iter_mut().enumerate() {
            let x = dot(&self.a[i * n..(i + 1) * n], &self.state);
            *next = onto(x, &self.b[i * self.m..(i + 1) * self.m], &u[..self.m]);
        }
        std::mem::swap(&mut self.state, &mut self.next);
    }

    /// The gain for outputs of this tick.
    fn weigh(&mut self) {
        let (n, p) = (self.n, self.p);
        let mut scale = [[0.0; Signals::MOST]; Signals::MOST];
        for (k, c) in self.c.chunks_exact(n).enumerate() {
            for i in 0..n {
                let sum = self.cross[i * p + k];
                self.reach[i * p + k] = onto(sum, c, &self.ahead[i * n..(i + 1) * n]);
            }
            for (l, other) in self.c.chunks_exact(n).enumerate() {
                let mut sum = self.output[k * p + l];
                for (j, row) in self.covariance.chunks_exact(n).enumerate() {
                    sum += dot(c, row) * other[j];
                }
                scale[k][l] = sum;
            }
        }
        let [[s00, s01], [s10, s11]] = scale;
        let rows = self.gain.chunks_exact_mut(p);
        for (gain, reach) in rows.zip(self.reach.chunks_exact(p)) {
            match (gain, reach) {
                ([gain], [w]) => *gain = w / s00,
                ([first, second], [w0, w1]) => {
                    let det = s00 * s11 - s01 * s10;
                    *first = (w0 * s11 - w1 * s10) / det;
                    *second = (w1 * s00 - w0 * s01) / det;
                }
                _ => {}
            }
        }
    }

    /// By how much the outputs differ from those that it expects.
    fn innovation(&self, u: Signals, y: Signals) -> [f64; Signals::MOST] {
        let (n, u) = (self.n, [u.first, u.second.unwrap_or_default()]);
        let mut y = [y.first, y.second.unwrap_or_default()];
        for (k, y) in y[..self.p].iter_mut().enumerate() {
            let x = dot(&self.c[k * n..(k + 1) * n], &self.state);
            *y -= onto(x, &self.d[k * self.m..(k + 1) * self.m], &u[..self.m]);
        }
        y
    }

    /// The covariance before the next tick, by the gain of this one.
    fn spread(&mut self) {
        let (n, p) = (self.n, self.p);
        let is_seen = self.gain.iter().any(|gain| *gain != 0.0);
        for i in 0..n {
            for j in i..n {
                let row = &self.ahead[i * n..(i + 1) * n];
                let mut entry = onto(self.drift[i * n + j], row, &self.a[j * n..(j + 1) * n]);
                if is_seen {
                    let gain = &self.gain[i * p..(i + 1) * p];
                    entry -= dot(gain, &self.reach[j * p..(j + 1) * p]);
                }
                self.covariance[i * n + j] = entry;
                self.covariance[j * n + i] = entry;
            }
        }
    }
}
