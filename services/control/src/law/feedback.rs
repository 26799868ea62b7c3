//! State feedback with a Kalman filter that estimates the state from late outputs.
//!
//! The output that a controller has at an update is some ticks old (see
//! [`crate::closed_loop::loop_delay_ticks`]). The filter's model is therefore the plant followed by a
//! delay line of its last outputs: the filter corrects all of them by the oldest, and the gains act
//! on the plant's present state. An update corrects, acts, and predicts, in this order (R. E. Kalman,
//! 1960). The filter is designed for outputs of one tick, and its corrections are carried on over the others:
//! with a state for each tick the design would take time with their cube. There is no integral, so a load that the model does not include leaves an offset.

use nalgebra::{DMatrix, DVector};

use super::swept::SweptFeedback;
use super::{InvalidLaw, limited};
use crate::pid::Saturation;
use crate::riccati;
use crate::signals::Signals;
use crate::state_space::StateSpace;
use crate::stepper::{dot, onto, row_by_row, rows};
use crate::timebase::Discrete;

/// Weights of an optimal regulator, which minimises the sum of output y² + input u² over all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// The weight of y² of each output.
    pub output: Vec<f64>,
    /// The weight of u² of each input, more than zero.
    pub input: Vec<f64>,
}

/// The noise that a Kalman filter assumes, as standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimator {
    /// Standard deviation of a white disturbance at each of the plant's inputs.
    pub disturbance: Vec<f64>,
    /// Standard deviation of white noise on each output, more than zero.
    pub noise: Vec<f64>,
}

/// u = reference r - gains x, with x estimated by the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct StateFeedback {
    model: StateSpace<Discrete>,
    gains: DMatrix<f64>,
    observer: DMatrix<f64>,
    reference: DMatrix<f64>,
    /// The references of the outputs after the first.
    others: Vec<f64>,
    limits: Option<Saturation>,
    /// The model's matrix row by row, as made by [`rows`], and the other matrices likewise.
    rows: Vec<f64>,
    c: Vec<f64>,
    d: Vec<f64>,
    by_state: Vec<f64>,
    by_innovation: Vec<f64>,
    /// The states, then the delay line of outputs, newest first.
    state: Vec<f64>,
    next: Vec<f64>,
    output: Signals,
}

impl Weights {
    /// The gains of the optimal regulator: a row for each input, an entry for each state.
    ///
    /// # Errors
    /// [`InvalidLaw::Riccati`] if there is no solution; [`InvalidLaw::Length`] if there are not as many weights
    /// as inputs and outputs.
    pub fn gains(&self, model: &StateSpace<Discrete>) -> Result<DMatrix<f64>, InvalidLaw> {
        length("weights.output", &self.output, model.outputs(), OUTPUTS)?;
        length("weights.input", &self.input, model.inputs(), INPUTS)?;
        let mut q = DMatrix::zeros(model.order(), model.order());
        for (row, weight) in model.c().row_iter().zip(&self.output) {
            q += row.transpose() * row * *weight;
        }
        let (a, b) = (model.a(), model.b());
        let x = riccati::solve(a, b, &q, &self.input)?;
        Ok(riccati::gains(a, b, &x, &self.input)?)
    }
}

impl Estimator {
    /// The steady filter's gains for outputs that are `delay` ticks old, at least one: a row for each state,
    /// then for each output in the delay line; a column for each output.
    ///
    /// # Errors
    /// [`InvalidLaw::Riccati`] if there is no solution; [`InvalidLaw::Length`] if there are not as many
    /// deviations as inputs and outputs.
    pub fn observer(
        &self,
        model: &StateSpace<Discrete>,
        delay: usize,
    ) -> Result<DMatrix<f64>, InvalidLaw> {
        let (_, newest) = self.steady(model)?;
        Ok(predicted(model, &newest, delay.max(1)))
    }

    /// The covariance of the state before a tick, if the outputs of all ticks before were seen.
    pub(super) fn covariance(
        &self,
        model: &StateSpace<Discrete>,
    ) -> Result<DMatrix<f64>, InvalidLaw> {
        let (p, newest) = self.steady(model)?;
        let n = model.order();
        let seen = p.rows(n, model.outputs());
        let covariance = p.view((0, 0), (n, n)) - newest.rows(0, n) * seen.columns(0, n);
        // Symmetric except for rounding.
        Ok((&covariance + covariance.transpose()) / 2.0)
    }

    /// The covariance of state and last output before the output is seen, and by what the filter corrects them.
    fn steady(
        &self,
        model: &StateSpace<Discrete>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), InvalidLaw> {
        length(
            "noise.disturbance",
            &self.disturbance,
            model.inputs(),
            INPUTS,
        )?;
        length("noise.measurement", &self.noise, model.outputs(), OUTPUTS)?;
        let (a, b) = with_line(model, 1);
        let c = last_of(a.nrows(), model.outputs());
        let mut q = DMatrix::zeros(a.nrows(), a.nrows());
        for (column, deviation) in b.column_iter().zip(&self.disturbance) {
            q += column * column.transpose() * deviation.powi(2);
        }
        let r: Vec<f64> = self
            .noise
            .iter()
            .map(|deviation| deviation.powi(2))
            .collect();
        let p = riccati::solve(&a.transpose(), &c.transpose(), &q, &r)?;
        let newest = riccati::corrections(&c, &p, &r)?;
        Ok((p, newest))
    }
}

/// The corrections by outputs that are `delay` ticks old, of those by outputs of one tick: what an output says of
/// the state after it is carried on by the model, and nothing else is known of the ticks since.
fn predicted(model: &StateSpace<Discrete>, newest: &DMatrix<f64>, delay: usize) -> DMatrix<f64> {
    let (n, p) = (model.order(), model.outputs());
    let mut all = DMatrix::zeros(n + delay * p, p);
    let mut state = newest.rows(0, n).into_owned();
    // The line has the newest output first.
    let oldest = n + (delay - 1) * p;
    all.rows_mut(oldest, p).copy_from(&newest.rows(n, p));
    for row in (n..oldest).step_by(p).rev() {
        all.rows_mut(row, p).copy_from(&(model.c() * &state));
        state = model.a() * state;
    }
    all.rows_mut(0, n).copy_from(&state);
    all
}

const INPUTS: &str = "one for each input";
const OUTPUTS: &str = "one for each output";

fn length(
    list: &'static str,
    given: &[f64],
    needed: usize,
    why: &'static str,
) -> Result<(), InvalidLaw> {
    if given.len() == needed {
        return Ok(());
    }
    Err(wrong(list, given.len(), needed, why))
}

fn wrong(list: &'static str, given: usize, needed: usize, why: &'static str) -> InvalidLaw {
    InvalidLaw::Length {
        list,
        given,
        needed,
        why,
    }
}

impl StateFeedback {
    /// A law at rest. `gains` has a row for each of the model's inputs and a column for each of its n states,
    /// `observer` a row for each state and then for each output in the delay line, and a column for each
    /// output. `others` are the references of the outputs after the first, where they have one. `None` leaves
    /// the commands unlimited.
    ///
    /// The references are scaled so that a plant equal to the model rests at them.
    ///
    /// # Errors
    /// [`InvalidLaw`] if shapes do not match, a number is not finite, the range of the limits is empty, or no
    /// constant command holds the outputs at their references.
    pub fn try_new(
        model: StateSpace<Discrete>,
        gains: DMatrix<f64>,
        observer: DMatrix<f64>,
        others: Vec<f64>,
        limits: Option<Saturation>,
    ) -> Result<Self, InvalidLaw> {
        limits.as_ref().map_or(Ok(()), Saturation::check)?;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        if gains.shape() != (m, n) {
            let why = "one for each state of the sampled model, for each input";
            return Err(wrong("gains", gains.len(), m * n, why));
        }
        let line = observer.nrows().saturating_sub(n);
        if observer.ncols() != p || line < p || line % p != 0 {
            let why = "or more: one for each state, and one for each tick that an output is old, for each output";
            return Err(wrong("observer", observer.len(), (n + p) * p, why));
        }
        for (field, list) in [
            ("gains", gains.as_slice()),
            ("observer", observer.as_slice()),
            ("r", &others),
        ] {
            if !list.iter().all(|x| x.is_finite()) {
                return Err(InvalidLaw::NotFinite { field });
            }
        }
        let reference = reference(&model, &gains, 1 + others.len()).ok_or(InvalidLaw::NoRest)?;
        Ok(Self {
            rows: rows(&model),
            c: row_by_row(model.c()),
            d: row_by_row(model.d()),
            by_state: row_by_row(&gains),
            by_innovation: row_by_row(&observer),
            state: vec![0.0; n + line],
            next: vec![0.0; n + line],
            output: Signals::zeros(m),
            model,
            gains,
            observer,
            reference,
            others,
            limits,
        })
    }

    /// The factors of the references: a row for each input, a column for each reference.
    #[must_use]
    pub fn reference(&self) -> &DMatrix<f64> {
        &self.reference
    }

    /// The model of its plant.
    pub(super) fn model(&self) -> &StateSpace<Discrete> {
        &self.model
    }

    /// Number of the plant's states and of the delay line's outputs.
    pub(super) fn order(&self) -> usize {
        self.state.len()
    }

    /// Number of outputs that it expects, and of inputs that it gives.
    pub(super) fn signals(&self) -> (usize, usize) {
        (self.model.outputs(), self.model.inputs())
    }

    pub(super) fn update(&mut self, r: f64, y: Signals) -> Signals {
        let (n, m, p) = (
            self.model.order(),
            self.model.inputs(),
            self.model.outputs(),
        );
        if !(r.is_finite() && y.is_finite() && y.count() == p) {
            return self.output;
        }
        let y = [y.first, y.second.unwrap_or_default()];
        let oldest = self.state.len() - p;
        let mut innovation = [0.0; Signals::MOST];
        for (k, innovation) in innovation[..p].iter_mut().enumerate() {
            *innovation = y[k] - self.state[oldest + k];
        }
        let innovation = &innovation[..p];
        let corrections = self.by_innovation.chunks_exact(p);
        for ((next, state), gains) in self.next.iter_mut().zip(&self.state).zip(corrections) {
            *next = onto(*state, gains, innovation);
        }
        // `next` has the corrected state; `state` gets the predicted one.
        let (x, line) = self.next.split_at(n);
        let u = self.commands(r, x);
        let u = &u[..m];
        let mut o = [0.0; Signals::MOST];
        for (k, o) in o[..p].iter_mut().enumerate() {
            *o = onto(
                dot(&self.c[k * n..(k + 1) * n], x),
                &self.d[k * m..(k + 1) * m],
                u,
            );
        }
        let rows = self.rows.chunks_exact(n + m);
        let predicted = rows.map(|row| onto(dot(&row[..n], x), &row[n..], u));
        let is_finite = u.iter().chain(&o).chain(line).all(|x| x.is_finite())
            && predicted.clone().all(f64::is_finite);
        if !is_finite {
            return self.output;
        }
        for (state, x) in self.state.iter_mut().zip(predicted) {
            *state = x;
        }
        self.state[n..n + p].copy_from_slice(&o[..p]);
        self.state[n + p..].copy_from_slice(&line[..line.len() - p]);
        self.output = Signals {
            first: u[0],
            second: u.get(1).copied(),
        };
        self.output
    }

    /// The commands for a state, without a step of the filter.
    pub(super) fn command(&self, r: f64, x: &[f64]) -> Signals {
        let [first, second] = self.commands(r, x);
        Signals {
            first,
            second: (self.model.inputs() > 1).then_some(second),
        }
    }

    /// The command for each input; 0 for one that there is not.
    #[inline]
    fn commands(&self, r: f64, x: &[f64]) -> [f64; Signals::MOST] {
        let (n, m) = (self.model.order(), self.model.inputs());
        let mut u = [0.0; Signals::MOST];
        for (j, u) in u[..m].iter_mut().enumerate() {
            let mut wanted = self.reference[(j, 0)] * r;
            for (i, other) in self.others.iter().enumerate() {
                wanted += self.reference[(j, i + 1)] * other;
            }
            let wanted = wanted - dot(&self.by_state[j * n..(j + 1) * n], x);
            *u = limited(wanted, self.limits.as_ref());
        }
        u
    }

    /// The law as a function of frequency; `None` if its numbers overflow.
    pub(super) fn swept(&self) -> Option<SweptFeedback> {
        SweptFeedback::new(&self.model, &self.gains, &self.observer)
    }

    /// From y to u with r = 0. With the observer L, the corrected state is (I - L C) s + L y, and the
    /// next state is (A - B K) times it.
    pub(super) fn state_space(&self) -> StateSpace<Discrete> {
        let (n, all, p) = (self.model.order(), self.state.len(), self.model.outputs());
        let (a, b) = with_line(&self.model, (all - n) / p);
        let mut k = DMatrix::zeros(self.model.inputs(), all);
        k.columns_mut(0, n).copy_from(&self.gains);
        let l = &self.observer;
        let corrected = DMatrix::identity(all, all) - l * last_of(all, p);
        let next = a - b * &k;
        let at_once = -(&k * l);
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

/// The factors of the first `count` references: u + K x, with u and x at rest for an output of 1 and the other
/// outputs that have a reference at 0. Where there are more inputs than references, the least such x and u.
fn reference(
    model: &StateSpace<Discrete>,
    gains: &DMatrix<f64>,
    count: usize,
) -> Option<DMatrix<f64>> {
    const ROUNDS: usize = 10_000;
    let (n, m) = (model.order(), model.inputs());
    if count > model.outputs() || count > m {
        return None;
    }
    let mut rest = DMatrix::zeros(n + count, n + m);
    rest.view_mut((0, 0), (n, n))
        .copy_from(&(model.a() - DMatrix::identity(n, n)));
    rest.view_mut((0, n), (n, m)).copy_from(model.b());
    rest.view_mut((n, 0), (count, n))
        .copy_from(&model.c().rows(0, count));
    rest.view_mut((n, n), (count, m))
        .copy_from(&model.d().rows(0, count));
    let mut factors = DMatrix::zeros(m, count);
    for i in 0..count {
        let mut wanted = DVector::zeros(n + count);
        wanted[n + i] = 1.0;
        let found = if m == count {
            rest.clone().lu().solve(&wanted)?
        } else {
            let parts = rest.clone().try_svd(true, true, f64::EPSILON, ROUNDS)?;
            parts.pseudo_inverse(1e-12).ok()? * wanted
        };
        for j in 0..m {
            let terms = gains.row(j).into_iter().zip(found.iter());
            factors[(j, i)] = terms.fold(found[n + j], |sum, (k, x)| sum + k * x);
        }
    }
    factors.iter().all(|x| x.is_finite()).then_some(factors)
}

/// A and B of the model followed by a delay line of `tau` ticks of its outputs, of which the first are this tick's.
fn with_line(model: &StateSpace<Discrete>, tau: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, m, p) = (model.order(), model.inputs(), model.outputs());
    let all = n + tau * p;
    let mut a = DMatrix::zeros(all, all);
    a.view_mut((0, 0), (n, n)).copy_from(model.a());
    a.view_mut((n, 0), (p, n)).copy_from(model.c());
    for i in p..tau * p {
        a[(n + i, n + i - p)] = 1.0;
    }
    let mut b = DMatrix::zeros(all, m);
    b.rows_mut(0, n).copy_from(model.b());
    b.rows_mut(n, p).copy_from(model.d());
    (a, b)
}

/// The matrix that selects the last `p` of `n` states.
fn last_of(n: usize, p: usize) -> DMatrix<f64> {
    let mut c = DMatrix::zeros(p, n);
    c.columns_mut(n - p, p).fill_with_identity();
    c
}
