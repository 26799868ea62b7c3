//! A law as numbers, in the form in which clients in other languages get it: one JSON object.
//!
//! `control::law` defines how a client uses them, sum by sum; test vectors check all clients.

use control::{AntiWindup, Discrete, Gains, Noise, Saturation, StateSpace};
use nalgebra::DMatrix;
use serde::Serialize;

/// A law for one sample time.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum Design {
    /// PI or PID of the error.
    Pid(PidNumbers),
    /// A sampled transfer function of the error.
    Transfer {
        /// The controller as a sampled model, from error to command.
        model: Model,
        /// The limits of the command.
        limits: Option<Limits>,
    },
    /// A PID around a model without its dead time.
    Smith {
        /// The PID.
        pid: PidNumbers,
        /// The plant, sampled, without its dead time.
        model: Model,
        /// Number of ticks by which the model is ahead.
        ticks: usize,
    },
    /// State feedback with a Kalman filter.
    StateFeedback {
        /// The plant, sampled, without its dead time.
        model: Matrices,
        /// For each input, one gain for each state.
        gains: Vec<Vec<f64>>,
        /// For each state, and then for each output of each tick of the outputs' age, one gain for each output.
        observer: Vec<Vec<f64>>,
        /// For each input, one factor for each reference.
        reference: Vec<Vec<f64>>,
        /// The references of the outputs after the first.
        others: Vec<f64>,
        /// The limits of the command.
        limits: Option<Limits>,
    },
    /// State feedback with a Kalman filter that knows how old each output is.
    AgedFeedback {
        /// The plant, sampled.
        model: Matrices,
        /// For each input, one gain for each state.
        gains: Vec<Vec<f64>>,
        /// For each input, one factor for each reference.
        reference: Vec<Vec<f64>>,
        /// The references of the outputs after the first.
        others: Vec<f64>,
        /// The limits of the command.
        limits: Option<Limits>,
        /// The time between two ticks of the plant.
        h_ns: u64,
        /// The filter's noise.
        noise: NoiseNumbers,
    },
}

/// The noise of a filter, as covariances.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseNumbers {
    /// Of the state when the filter begins: a row for each state.
    pub covariance: Vec<Vec<f64>>,
    /// What a tick adds to it: a row for each state.
    pub drift: Vec<Vec<f64>>,
    /// Between that and the outputs' noise: for each state, one entry for each output.
    pub cross: Vec<Vec<f64>>,
    /// Of the outputs' noise: a row for each output.
    pub output: Vec<Vec<f64>>,
}

/// A PID's gains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PidNumbers {
    /// Proportional gain kp.
    pub kp: f64,
    /// Integral gain, 1/s.
    pub ki: f64,
    /// Derivative gain, s.
    pub kd: f64,
    /// The pole of the derivative's filter, rad/s; `None` means a plain difference.
    pub filter_rad_s: Option<f64>,
    /// The limits of the command.
    pub limits: Option<Limits>,
}

/// Limits of the command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// The smallest command; `None` if unlimited.
    pub min: Option<f64>,
    /// The largest command; `None` if unlimited.
    pub max: Option<f64>,
    /// `off`, `conditional` or `back-calculation`.
    pub anti_windup: &'static str,
    /// The tracking gain of back-calculation, 1/s.
    pub gain_per_s: Option<f64>,
}

/// A sampled model, with as many inputs and outputs as the plant: next x = a x + b u, y = c x + d u, each
/// matrix as rows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Matrices {
    /// The state matrix A.
    pub a: Vec<Vec<f64>>,
    /// For each state, one entry for each input.
    pub b: Vec<Vec<f64>>,
    /// For each output, one entry for each state.
    pub c: Vec<Vec<f64>>,
    /// For each output, one entry for each input.
    pub d: Vec<Vec<f64>>,
}

/// A sampled model of one input and one output: next x = a x + b u, y = c x + d u.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Model {
    /// The state matrix A, as rows.
    pub a: Vec<Vec<f64>>,
    /// One entry for each state.
    pub b: Vec<f64>,
    /// One entry for each state.
    pub c: Vec<f64>,
    /// The feed-through D.
    pub d: f64,
}

impl PidNumbers {
    pub(crate) fn new(gains: &Gains, limits: Option<&Saturation>) -> Self {
        Self {
            kp: gains.kp,
            ki: gains.ki,
            kd: gains.kd,
            filter_rad_s: finite(gains.filter_rad_s),
            limits: limits.map(Limits::from),
        }
    }
}

impl From<&Saturation> for Limits {
    fn from(limits: &Saturation) -> Self {
        let (anti_windup, gain_per_s) = match limits.anti_windup {
            AntiWindup::Off => ("off", None),
            AntiWindup::Conditional => ("conditional", None),
            AntiWindup::BackCalculation { gain_per_s } => ("back-calculation", Some(gain_per_s)),
        };
        Self {
            min: finite(limits.min),
            max: finite(limits.max),
            anti_windup,
            gain_per_s,
        }
    }
}

impl From<&StateSpace<Discrete>> for Model {
    fn from(system: &StateSpace<Discrete>) -> Self {
        Self {
            a: to_rows(system.a()),
            b: system.b().iter().copied().collect(),
            c: system.c().iter().copied().collect(),
            d: system.d0(),
        }
    }
}

impl From<&StateSpace<Discrete>> for Matrices {
    fn from(system: &StateSpace<Discrete>) -> Self {
        Self {
            a: to_rows(system.a()),
            b: to_rows(system.b()),
            c: to_rows(system.c()),
            d: to_rows(system.d()),
        }
    }
}

impl From<&Noise> for NoiseNumbers {
    fn from(noise: &Noise) -> Self {
        Self {
            covariance: to_rows(&noise.covariance),
            drift: to_rows(&noise.drift),
            cross: to_rows(&noise.cross),
            output: to_rows(&noise.output),
        }
    }
}

/// The rows of a matrix.
pub(crate) fn to_rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
