//! A law as a function of frequency: u = -K y with r = 0, by the law's own states or, of what delays it
//! contains, by their powers of z.

use nalgebra::{Complex, DMatrix};

use super::Law;
use crate::pid::Gains;
use crate::state_space::StateSpace;
use crate::swept::{Corner, Swept, Told, complex, delay, difference, over_h, step};
use crate::timebase::Discrete;
use crate::wide::matrix::Matrix;

/// A law, prepared to be asked at many frequencies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SweptLaw {
    Pid {
        gains: Gains,
        h_s: f64,
    },
    Transfer(Swept),
    Smith {
        gains: Gains,
        model: Swept,
        ticks: usize,
        h_s: f64,
    },
    Feedback(Box<SweptFeedback>),
}

/// A state feedback: its corrected state by what its filter did not expect, and the line of its last outputs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SweptFeedback {
    /// From what was not expected to the corrected state over h: (δ - (A - B K - 1)/h)⁻¹ L.
    corrected: Swept,
    /// K.
    gains: DMatrix<f64>,
    /// C - D K.
    shown: DMatrix<f64>,
    /// What corrects each output in the line, the newest first, without the oldest.
    line: Vec<DMatrix<f64>>,
    h_s: f64,
}

impl SweptLaw {
    /// `None` if its numbers overflow.
    pub(crate) fn new(law: &Law, h_s: f64) -> Option<Self> {
        Some(match law {
            Law::Pid(pid) => Self::Pid {
                gains: pid.gains(),
                h_s,
            },
            Law::Transfer(law) => Self::Transfer(Swept::sampled(&law.state_space())?),
            Law::Smith(law) => Self::Smith {
                gains: law.gains(),
                model: Swept::seen(law.model())?,
                ticks: law.ticks_ahead(),
                h_s,
            },
            Law::StateFeedback(law) => Self::Feedback(Box::new(law.swept()?)),
            Law::Aged(law) => Self::Feedback(Box::new(law.assumed().swept()?)),
        })
    }

    /// The law at the angle `theta`; `None` at a pole.
    pub(crate) fn at(&self, theta: f64) -> Option<Told> {
        match self {
            Self::Pid { gains, h_s } => {
                let (gain, turn) = pid(gains, *h_s, theta)?;
                Some(single(gain, turn))
            }
            // Its state space is from y to u, with the sign of the feedback.
            Self::Transfer(law) => law.at(theta).map(|told| Told {
                gain: -told.gain,
                ..told
            }),
            Self::Smith {
                gains,
                model,
                ticks,
                h_s,
            } => {
                let (c, turn) = pid(gains, *h_s, theta)?;
                let told = model.at(theta)?;
                // C / (1 + C M z^-1 (1 - z^-t)).
                let ahead = -step(-theta * *ticks as f64);
                let inner = 1.0 + c * told.gain[(0, 0)] * delay(theta) * ahead;
                let gain = c / inner;
                let turn = turn * told.turn * unit(inner)?;
                gain.is_finite().then(|| single(gain, turn))
            }
            Self::Feedback(law) => law.at(theta),
        }
    }

    pub(crate) fn corners(&self) -> Vec<Corner> {
        match self {
            Self::Pid { gains, h_s } => of_pid(gains, *h_s),
            Self::Transfer(law) => law.corners().to_vec(),
            Self::Smith {
                gains, model, h_s, ..
            } => {
                let mut corners = of_pid(gains, *h_s);
                corners.extend(model.corners());
                corners
            }
            Self::Feedback(law) => law.corrected.corners().to_vec(),
        }
    }

    /// The longest delay that the law contains, in ticks: its response turns as often.
    pub(crate) fn ticks(&self) -> usize {
        match self {
            Self::Pid { .. } | Self::Transfer(_) => 0,
            Self::Smith { ticks, .. } => *ticks,
            Self::Feedback(law) => law.line.len() + 1,
        }
    }

    /// Whether what the law delays counts at this angle: of a predictor, where its inner loop is not idle.
    pub(crate) fn looks_back(&self, theta: f64) -> bool {
        const IDLE: f64 = 1e-4;
        match self {
            Self::Pid { .. } | Self::Transfer(_) => false,
            Self::Smith {
                gains, model, h_s, ..
            } => match (pid(gains, *h_s, theta), model.at(theta)) {
                (Some((c, _)), Some(told)) => (c * told.gain[(0, 0)]).norm() > IDLE,
                _ => true,
            },
            Self::Feedback(_) => true,
        }
    }
}

impl SweptFeedback {
    /// `gains` K, `observer` L with a row for each state and then for each output in the line.
    pub(super) fn new(
        model: &StateSpace<Discrete>,
        gains: &DMatrix<f64>,
        observer: &DMatrix<f64>,
    ) -> Option<Self> {
        let h_s = model.timebase().h_s();
        let (n, p) = (model.order(), model.outputs());
        let fed = over_h(model.b(), h_s).times(&Matrix::from(gains));
        let a = difference(model.a(), h_s).plus(&fed.each(|x| -x));
        let entering = Matrix::from(&observer.rows(0, n).into_owned());
        let rows: Vec<DMatrix<f64>> = (n..observer.nrows())
            .step_by(p)
            .map(|row| observer.rows(row, p).into_owned())
            .collect();
        let (_, line) = rows.split_last()?;
        let every = Matrix::identity(n);
        Some(Self {
            corrected: Swept::new(&a, &entering, &every, &DMatrix::zeros(n, p), h_s)?,
            gains: gains.clone(),
            shown: model.c() - model.d() * gains,
            line: line.to_vec(),
            h_s,
        })
    }

    fn at(&self, theta: f64) -> Option<Told> {
        let told = self.corrected.at(theta)?;
        // z (z - A + B K)⁻¹ L, and δ - .. is that over h.
        let state = told.gain * (Complex::from_polar(1.0, theta) / self.h_s);
        let p = self.shown.nrows();
        let line = self.line.len() as f64 + 1.0;
        // What the filter expected is in the line since then.
        let mut e = complex(&DMatrix::identity(p, p));
        e += complex(&self.shown) * &state * delay(theta * line);
        for (i, correction) in self.line.iter().enumerate() {
            e += complex(correction) * delay(theta * (line - 1.0 - i as f64));
        }
        let turn = told.turn * unit(determinant(&e))?;
        let gain = complex(&self.gains) * state * inverse(&e)?;
        gain.iter()
            .all(|g| g.is_finite())
            .then_some(Told { gain, turn })
    }
}

fn single(gain: Complex<f64>, turn: Complex<f64>) -> Told {
    Told {
        gain: DMatrix::from_element(1, 1, gain),
        turn,
    }
}

/// A number over its magnitude; `None` for 0.
fn unit(x: Complex<f64>) -> Option<Complex<f64>> {
    let size = x.norm();
    (size > 0.0 && size.is_finite()).then(|| x / size)
}

/// The determinant of a matrix of one or two rows.
pub(crate) fn determinant(m: &DMatrix<Complex<f64>>) -> Complex<f64> {
    match m.nrows() {
        1 => m[(0, 0)],
        _ => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
    }
}

fn inverse(m: &DMatrix<Complex<f64>>) -> Option<DMatrix<Complex<f64>>> {
    m.clone().try_inverse()
}

/// The law at an angle, from the error to the command, and the angle of the product of 1 - p/z over its poles.
fn pid(gains: &Gains, h_s: f64, theta: f64) -> Option<(Complex<f64>, Complex<f64>)> {
    // 1 - 1/z.
    let back = -step(-theta);
    let mut gain = Complex::new(gains.kp, 0.0);
    let mut turn = Complex::new(1.0, 0.0);
    if gains.ki != 0.0 {
        gain += gains.ki * h_s / back;
        turn *= unit(back)?;
    }
    if gains.kd != 0.0 {
        // kd (1 - 1/z) / (h + lag (1 - 1/z)).
        let lag_s = gains.filter_rad_s.recip();
        let filter = h_s + lag_s * back;
        gain += gains.kd * back / filter;
        turn *= unit(filter)?;
    }
    gain.is_finite().then_some((gain, turn))
}

/// Where the terms of the law take over from each other, and the filter's corner.
fn of_pid(gains: &Gains, h_s: f64) -> Vec<Corner> {
    let real = |rad_s: f64| Corner::of(Complex::new(-rad_s.abs(), 0.0), h_s);
    let corners = [
        gains.ki / gains.kp,
        gains.kp / gains.kd,
        (gains.ki / gains.kd).abs().sqrt(),
        gains.filter_rad_s,
    ];
    let there = corners
        .into_iter()
        .filter(|rad_s| rad_s.is_finite() && *rad_s != 0.0);
    there.map(real).collect()
}
