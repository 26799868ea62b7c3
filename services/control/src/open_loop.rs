//! A loop opened at its narrower place: a plant with its law, or a transfer function, as a function of frequency.
//!
//! With one input or one output that is one complex number, L. With two of both they are two, the eigenvalues of
//! the loop's matrix (its characteristic loci; A. G. J. `MacFarlane` and I. Postlethwaite, 1977), which mean for a
//! change of both channels at once what L means for one.

use nalgebra::{Complex, DMatrix};

use crate::discretise::InvalidDiscretisation;
use crate::law::Law;
use crate::law::swept::{SweptLaw, determinant};
use crate::minimal::{Fate, Hidden, Minimal};
use crate::plant::Plant;
use crate::polynomial::trimmed;
use crate::swept::{Corner, Form, Swept, step};
use crate::timebase::{Timebase, seconds};
use crate::transfer::TransferFunction;
use crate::wide::{Wide, WideComplex};

/// A loop, opened: what margins are computed of.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLoop {
    kind: Kind,
    /// Dead time of its own, in whole samples.
    delay_ticks: usize,
    h_s: Option<f64>,
    hidden: Vec<Hidden>,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Ratio {
        num: Vec<Wide>,
        den: Vec<Wide>,
        corners: Vec<Corner>,
    },
    Loop {
        plant: Box<Swept>,
        /// The plant once more, in other states, which round differently; where margins are asked.
        again: Option<Box<Swept>>,
        law: Box<SweptLaw>,
        corners: Vec<Corner>,
    },
}

/// The loop at a frequency, without its own dead time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// The angle of the product of 1 - p/z over the open loop's poles, on the unit circle.
    pub(crate) turn: Complex<f64>,
    /// L, or both loci; the second is 0 if there is one.
    pub(crate) loci: [Complex<f64>; 2],
}

impl OpenLoop {
    /// `plant` and `law`, both with `h_ns`: from an error to the plant's next output, without a network.
    ///
    /// # Errors
    /// [`InvalidDiscretisation`] if the numbers overflow.
    pub fn new(plant: &Plant, law: &Law, h_ns: u64) -> Result<Self, InvalidDiscretisation> {
        let h_s = seconds(h_ns);
        let overflow = || InvalidDiscretisation::Overflow { h_s };
        let minimal = Minimal::of(&plant.model);
        let swept = |form| Swept::plant(plant, &minimal, h_ns, form).ok_or_else(overflow);
        let ticks = plant.dead_time_ns / h_ns.max(1);
        let law = SweptLaw::new(law, h_s).ok_or_else(overflow)?;
        let ticks = usize::try_from(ticks).unwrap_or(usize::MAX);
        let second = swept(Form::Again)?;
        let mut open = Self::around(swept(Form::Direct)?, law, h_s, ticks, h_s);
        if let Kind::Loop { again, .. } = &mut open.kind {
            *again = Some(Box::new(second));
        }
        open.hidden = minimal.hidden;
        Ok(open)
    }

    /// A plant and a law that was sampled every `of_law_s`, both stepped every `h_s`, with a dead time of
    /// `delay_ticks` such steps. Of it stability can be asked, and no doubt of its margins is known.
    pub(crate) fn around(
        plant: Swept,
        law: SweptLaw,
        of_law_s: f64,
        delay_ticks: usize,
        h_s: f64,
    ) -> Self {
        let mut corners = law.corners();
        for corner in &mut corners {
            corner.rad_s *= of_law_s / h_s;
        }
        corners.extend(plant.corners());
        Self {
            kind: Kind::Loop {
                plant: Box::new(plant),
                again: None,
                law: Box::new(law),
                corners,
            },
            delay_ticks,
            h_s: Some(h_s),
            hidden: Vec::new(),
        }
    }

    /// The modes of the plant that no loop around it sees, since a zero cancels each.
    #[must_use]
    pub fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    /// Whether a mode that the loop does not see grows, so that no law can hold the plant.
    #[must_use]
    pub fn grows_unseen(&self) -> bool {
        self.hidden.iter().any(|mode| mode.fate == Fate::Grows)
    }

    /// The sample time in seconds; `None` for a continuous loop.
    #[must_use]
    pub fn h_s(&self) -> Option<f64> {
        self.h_s
    }

    pub(crate) fn nyquist_rad_s(&self) -> Option<f64> {
        self.h_s.map(|h_s| std::f64::consts::PI / h_s)
    }

    /// Its own dead time.
    pub(crate) fn dead_time_s(&self) -> f64 {
        self.h_s.map_or(0.0, |h_s| self.delay_ticks as f64 * h_s)
    }

    pub(crate) fn corners(&self) -> Vec<Corner> {
        match &self.kind {
            Kind::Ratio { corners, .. } | Kind::Loop { corners, .. } => corners.clone(),
        }
    }

    /// Whether a pole lies at frequency 0, as far as can be told.
    pub(crate) fn has_integrator(&self) -> bool {
        // A pole at 0 of several is off by a root of the precision.
        const AT_REST: f64 = 1e-7;
        let corners = self.corners();
        let highest = corners.iter().fold(0.0, |most: f64, c| most.max(c.rad_s));
        corners
            .iter()
            .any(|corner| corner.rad_s <= AT_REST * highest)
    }

    /// The greatest step, rad/s, that does not skip a turn of what the law delays; `None` where that is idle.
    pub(crate) fn step_rad_s(&self, rad_s: f64) -> Option<f64> {
        // A dozen points in a turn.
        const PART_RAD: f64 = 0.5;
        let (Kind::Loop { law, .. }, Some(h_s)) = (&self.kind, self.h_s) else {
            return None;
        };
        let ticks = law.ticks();
        (ticks > 1 && law.looks_back(rad_s * h_s)).then(|| PART_RAD / (ticks as f64 * h_s))
    }

    /// The loop at `rad_s`; `None` at a pole.
    pub(crate) fn at(&self, rad_s: f64) -> Option<Point> {
        match &self.kind {
            Kind::Ratio { num, den, .. } => self.ratio(num, den, rad_s),
            Kind::Loop { plant, law, .. } => {
                let theta = rad_s * self.h_s?;
                let (plant, law) = (plant.at(theta)?, law.at(theta)?);
                let loci = loci(&around(&plant.gain, &law.gain));
                let turn = plant.turn * law.turn;
                loci.iter()
                    .all(|x| x.is_finite())
                    .then_some(Point { turn, loci })
            }
        }
    }

    /// How far two computations of the plant's response that round differently lie apart, as a part of it; 0 where
    /// there is one alone.
    pub(crate) fn doubt(&self, rad_s: f64) -> f64 {
        let (
            Kind::Loop {
                plant,
                again: Some(again),
                ..
            },
            Some(h_s),
        ) = (&self.kind, self.h_s)
        else {
            return 0.0;
        };
        let theta = rad_s * h_s;
        match (plant.at(theta), again.at(theta)) {
            (Some(one), Some(other)) => {
                let size = one.gain.norm();
                let off = (one.gain - other.gain).norm();
                if off == 0.0 { 0.0 } else { off / size }
            }
            _ => f64::INFINITY,
        }
    }

    fn ratio(&self, num: &[Wide], den: &[Wide], rad_s: f64) -> Option<Point> {
        let (x, later) = match self.h_s {
            Some(h_s) => {
                let theta = rad_s * h_s;
                let turns = theta * (den.len() as f64 - 1.0);
                (step(theta), Complex::from_polar(1.0, -turns))
            }
            None => (Complex::new(0.0, rad_s), Complex::new(1.0, 0.0)),
        };
        let (num, den) = (value(num, x), value(den, x));
        let l = (num / den).rounded();
        let size = den.rounded().norm();
        (l.is_finite() && size > 0.0).then(|| Point {
            turn: den.rounded() / size * later,
            loci: [l, Complex::new(0.0, 0.0)],
        })
    }
}

/// The loop's matrix on its narrower side.
fn around(plant: &DMatrix<Complex<f64>>, law: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    if plant.ncols() <= plant.nrows() {
        law * plant
    } else {
        plant * law
    }
}

/// The eigenvalues of a matrix of one or two rows.
fn loci(l: &DMatrix<Complex<f64>>) -> [Complex<f64>; 2] {
    if l.nrows() == 1 {
        return [l[(0, 0)], Complex::new(0.0, 0.0)];
    }
    let mean = (l[(0, 0)] + l[(1, 1)]) * 0.5;
    let apart = (l[(0, 0)] - l[(1, 1)]) * 0.5;
    let root = (apart * apart + l[(0, 1)] * l[(1, 0)]).sqrt();
    // The larger one is a sum without cancellation; the other follows from the product.
    let larger = if (mean + root).norm() >= (mean - root).norm() {
        mean + root
    } else {
        mean - root
    };
    let smaller = determinant(l) / larger;
    [
        larger,
        if smaller.is_finite() {
            smaller
        } else {
            Complex::new(0.0, 0.0)
        },
    ]
}

fn value(coefficients: &[Wide], x: Complex<f64>) -> WideComplex {
    let x = WideComplex::from(x);
    coefficients
        .iter()
        .fold(WideComplex::ZERO, |sum, c| sum * x + (*c).into())
}

/// The coefficients of p(x + 1): near z = 1 they keep the digits that those in z lose.
fn shifted(coefficients: &[f64]) -> Vec<Wide> {
    let mut shifted: Vec<Wide> = coefficients.iter().map(|c| Wide::from(*c)).collect();
    for end in (1..shifted.len()).rev() {
        for i in 1..=end {
            let before = shifted[i - 1];
            shifted[i] += before;
        }
    }
    shifted
}

impl<T: Timebase> From<&TransferFunction<T>> for OpenLoop {
    fn from(system: &TransferFunction<T>) -> Self {
        let h_s = system.timebase().sample_time_s();
        let (mut num, mut den) = (trimmed(system.num()).to_vec(), system.den().to_vec());
        let mut delay_ticks = 0;
        if h_s.is_some() {
            // Poles at the origin are dead time, unless a zero is there too.
            while den.len() > 1 && den.last() == Some(&0.0) {
                den.pop();
                if num.len() > 1 && num.last() == Some(&0.0) {
                    num.pop();
                } else {
                    delay_ticks += 1;
                }
            }
        }
        let roots = system.poles().into_iter().chain(system.zeros());
        let corners = roots
            .filter_map(|root| {
                let rad_s = system.timebase().corner_rad_s(root);
                let s = h_s.map_or(root, |h_s| root.ln() / h_s);
                let damping = (s.re / s.norm()).abs();
                (rad_s > 0.0 && rad_s.is_finite()).then_some(Corner { rad_s, damping })
            })
            .collect();
        let coefficients = |of: &[f64]| match h_s {
            Some(_) => shifted(of),
            None => of.iter().map(|c| Wide::from(*c)).collect(),
        };
        Self {
            kind: Kind::Ratio {
                num: coefficients(&num),
                den: coefficients(&den),
                corners,
            },
            delay_ticks,
            h_s,
            hidden: Vec::new(),
        }
    }
}

impl From<&OpenLoop> for OpenLoop {
    fn from(other: &OpenLoop) -> Self {
        other.clone()
    }
}
