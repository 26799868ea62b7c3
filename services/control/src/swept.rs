//! A sampled system as a function of frequency, by its states: C (v - A)⁻¹ B + D.
//!
//! The variable v is not z, near which the poles of a plant crowd as h gets short, but (z - 1)/h, or the s that a
//! method of sampling puts in its place: there they lie as far apart as they do without sampling.

use nalgebra::{Complex, DMatrix};

use crate::discretise::Method;
use crate::hessenberg::Hessenberg;
use crate::minimal::Minimal;
use crate::plant::Plant;
use crate::state_space::StateSpace;
use crate::timebase::{Discrete, seconds};
use crate::wide::Wide;
use crate::wide::matrix::{Matrix, held};

/// A sampled system, prepared to be asked at many frequencies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Swept {
    form: Hessenberg,
    d: DMatrix<f64>,
    variable: Variable,
    /// Of an input whose last value acts for a part of the sample, what of it reaches the output at once: B has
    /// twice as many columns then.
    last: Option<DMatrix<f64>>,
    h_s: f64,
    /// Where to look closely, rad/s, with the damping there.
    corners: Vec<Corner>,
}

/// A frequency at which a pole bends the response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    pub(crate) rad_s: f64,
    /// How far the pole lies from the frequency axis, as a part of its distance from the origin.
    pub(crate) damping: f64,
}

/// In which states a plant's response is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// In its own.
    Direct,
    /// In the same in another order and of other sizes, so that all rounding is another.
    Again,
}

/// What stands for s.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Variable {
    /// (z - 1) / h.
    Difference,
    /// (z - 1) / (z h).
    Backward,
    /// 2 (z - 1) / (h (z + 1)).
    Trapezoid,
}

/// The response at an angle θ = ω h.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Told {
    /// A row for each output, a column for each input.
    pub(crate) gain: DMatrix<Complex<f64>>,
    /// The angle of the product of 1 - p/z over the poles p, as a number on the unit circle.
    pub(crate) turn: Complex<f64>,
}

/// e^(-jθ).
pub(crate) fn delay(theta: f64) -> Complex<f64> {
    Complex::from_polar(1.0, -theta)
}

/// e^(jθ) - 1, to the last digit also where θ is small.
pub(crate) fn step(theta: f64) -> Complex<f64> {
    let half = theta / 2.0;
    Complex::new(0.0, 2.0 * half.sin()) * Complex::from_polar(1.0, half)
}

impl Variable {
    fn at(self, theta: f64, h_s: f64) -> Complex<f64> {
        match self {
            Self::Difference => step(theta) / h_s,
            Self::Backward => -step(-theta) / h_s,
            Self::Trapezoid => Complex::new(0.0, 2.0 / h_s * (theta / 2.0).tan()),
        }
    }

    /// What the product of v - a over the poles a of this variable lacks of the product of 1 - p/z, for each.
    fn factor(self, theta: f64) -> Complex<f64> {
        match self {
            Self::Difference => delay(theta),
            Self::Backward => Complex::new(1.0, 0.0),
            // 1 + 1/z points to half the angle.
            Self::Trapezoid => delay(theta / 2.0),
        }
    }
}

impl Swept {
    /// A plant sampled every `h_ns`, without the whole samples of its dead time, by the part of its continuous
    /// model that a loop sees. `None` if it overflows.
    pub(crate) fn plant(plant: &Plant, minimal: &Minimal, h_ns: u64, form: Form) -> Option<Self> {
        let h_s = seconds(h_ns);
        let (a, b, c) = match form {
            Form::Direct => (minimal.a.clone(), minimal.b.clone(), minimal.c.clone()),
            Form::Again => again(minimal),
        };
        let rest_ns = plant.dead_time_ns.checked_rem(h_ns)?;
        let (a, b, variable) = match plant.method {
            Method::BackwardEuler => (a, b, Variable::Backward),
            Method::Tustin => (a, b, Variable::Trapezoid),
            Method::ZeroOrderHold => {
                let (a, b) = sampled(&a, &b, h_ns, rest_ns);
                (a, b, Variable::Difference)
            }
        };
        let poles = eigen(&minimal.a);
        let d = plant.model.d().clone();
        let (d, last) = match rest_ns {
            0 => (d, None),
            _ => (d.clone() * 0.0, Some(d)),
        };
        Some(Self {
            d,
            last,
            corners: poles
                .into_iter()
                .map(|pole| Corner::of(pole, h_s))
                .collect(),
            form: finite(a, b, c)?,
            variable,
            h_s,
        })
    }

    /// A system that is sampled already, by the very numbers that are run.
    pub(crate) fn sampled(system: &StateSpace<Discrete>) -> Option<Self> {
        Self::new(
            &difference(system.a(), system.timebase().h_s()),
            &over_h(system.b(), system.timebase().h_s()),
            &Matrix::from(system.c()),
            system.d(),
            system.timebase().h_s(),
        )
    }

    /// The same without modes that stay or grow and that a loop does not see.
    pub(crate) fn seen(system: &StateSpace<Discrete>) -> Option<Self> {
        let h_s = system.timebase().h_s();
        let (a, b) = (difference(system.a(), h_s), over_h(system.b(), h_s));
        let seen = Minimal::sampled(a, b, system.c().into(), h_s);
        Self::new(&seen.a, &seen.b, &seen.c, system.d(), h_s)
    }

    /// C (δ - A)⁻¹ B + D with δ = (z - 1)/h.
    pub(crate) fn new(
        a: &Matrix,
        b: &Matrix,
        c: &Matrix,
        d: &DMatrix<f64>,
        h_s: f64,
    ) -> Option<Self> {
        let poles = eigen(a);
        let corners = poles.into_iter().filter_map(|delta| {
            let z = 1.0 + delta * h_s;
            (z.norm() > 0.0).then(|| Corner::of(near_log(delta * h_s) / h_s, h_s))
        });
        Some(Self {
            corners: corners.collect(),
            form: finite(a.clone(), b.clone(), c.clone())?,
            d: d.clone(),
            variable: Variable::Difference,
            last: None,
            h_s,
        })
    }

    /// The same with an input whose last value acts for a part of the sample: what that value adds is beside what
    /// the next one does.
    pub(crate) fn split(
        a: &Matrix,
        [next, last]: [Matrix; 2],
        c: &Matrix,
        [d, at_once]: [&DMatrix<f64>; 2],
        h_s: f64,
    ) -> Option<Self> {
        Some(Self {
            last: Some(at_once.clone()),
            ..Self::new(a, &next.beside(&last), c, d, h_s)?
        })
    }

    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The response at the angle `theta`; `None` at a pole.
    pub(crate) fn at(&self, theta: f64) -> Option<Told> {
        let solved = self.form.at(self.variable.at(theta, self.h_s))?;
        let gain = match &self.last {
            Some(last) => {
                let m = self.d.ncols();
                let (by_next, by_last) = (solved.gain.columns(0, m), solved.gain.columns(m, m));
                by_next + complex(&self.d) + (by_last + complex(last)) * delay(theta)
            }
            None => solved.gain + complex(&self.d),
        };
        let factor = self.variable.factor(theta).powu(self.form.order() as u32);
        Some(Told {
            gain,
            turn: solved.turn * factor,
        })
    }
}

impl Corner {
    /// Of a pole in s; a sampled loop sees the frequencies of faster ones mirrored.
    pub(crate) fn of(pole: Complex<f64>, h_s: f64) -> Self {
        let nyquist = std::f64::consts::PI / h_s;
        let rad_s = if pole.im.abs() > pole.re.abs() {
            pole.im.abs()
        } else {
            pole.norm()
        };
        let turned = rad_s.rem_euclid(2.0 * nyquist);
        Self {
            rad_s: if rad_s <= nyquist {
                rad_s
            } else {
                turned.min(2.0 * nyquist - turned)
            },
            damping: (pole.re / pole.norm()).abs(),
        }
    }
}

/// A matrix of real numbers as one of complex ones.
pub(crate) fn complex(m: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    m.map(|x| Complex::new(x, 0.0))
}

/// ln(1 + x), to the last digits also for small x.
fn near_log(x: Complex<f64>) -> Complex<f64> {
    if x.norm() < 1e-5 {
        x * (1.0 - x * 0.5)
    } else {
        (1.0 + x).ln()
    }
}

/// The states in reverse order, each times another power of three.
fn again(minimal: &Minimal) -> (Matrix, Matrix, Matrix) {
    let n = minimal.a.rows();
    let size = |i: usize| Wide::from([1.0, 3.0, 9.0][i % 3]);
    let (mut a, mut b, mut c) = (minimal.a.clone(), minimal.b.clone(), minimal.c.clone());
    for i in 0..n {
        let from = n - 1 - i;
        for j in 0..n {
            a[(i, j)] = minimal.a[(from, n - 1 - j)] * size(i) / size(j);
        }
        for j in 0..b.columns() {
            b[(i, j)] = minimal.b[(from, j)] * size(i);
        }
        for j in 0..c.rows() {
            c[(j, i)] = minimal.c[(j, from)] / size(i);
        }
    }
    (a, b, c)
}

fn eigen(a: &Matrix) -> Vec<Complex<f64>> {
    Hessenberg::new(
        a.clone(),
        Matrix::zeros(a.rows(), 0),
        Matrix::zeros(0, a.rows()),
    )
    .poles()
}

fn finite(a: Matrix, b: Matrix, c: Matrix) -> Option<Hessenberg> {
    let is_finite = a.is_finite() && b.is_finite() && c.is_finite();
    is_finite.then(|| Hessenberg::new(a, b, c))
}

/// (A - 1)/h, exactly: near 1 the digits that count are those after it.
pub(crate) fn difference(a: &DMatrix<f64>, h_s: f64) -> Matrix {
    let h = Wide::from(h_s);
    Matrix::from(a)
        .plus(&Matrix::identity(a.nrows()).each(|x| -x))
        .each(|x| x / h)
}

pub(crate) fn over_h(b: &DMatrix<f64>, h_s: f64) -> Matrix {
    let h = Wide::from(h_s);
    Matrix::from(b).each(|x| x / h)
}

/// (e^(A h) - 1)/h and what a held input adds in a sample, over h; if an input acts `rest_ns` after a sample, what
/// the next one adds and, beside it, what the last one does (K. J. Astrom and B. Wittenmark, Computer-Controlled
/// Systems, 3.2).
fn sampled(a: &Matrix, b: &Matrix, h_ns: u64, rest_ns: u64) -> (Matrix, Matrix) {
    let h_s = seconds(h_ns);
    let mean = held(a, h_s);
    let difference = a.times(&mean);
    if rest_ns == 0 {
        return (difference, mean.times(b));
    }
    let (rest_s, first_s) = (seconds(rest_ns), seconds(h_ns - rest_ns));
    let part = |t_s: f64| {
        let mean = held(a, t_s);
        let share = Wide::from(t_s) / Wide::from(h_s);
        (a.times(&mean), mean.times(b).each(|x| x * share))
    };
    let (_, last) = part(rest_s);
    let (grown, next) = part(first_s);
    let t = Wide::from(first_s);
    let after = Matrix::identity(a.rows()).plus(&grown.each(|x| x * t));
    (difference, next.beside(&after.times(&last)))
}
