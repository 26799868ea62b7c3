//! Transfer functions with one input and one output: num(s)/den(s) or num(z)/den(z), highest power
//! first.

use nalgebra::Complex;
use thiserror::Error;

use crate::polynomial::{from_roots, product, roots, sum, trimmed, value};
use crate::timebase::{Continuous, Timebase};

/// A proper transfer function with finite coefficients, in the variable of its [`Timebase`].
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction<T: Timebase = Continuous> {
    num: Vec<f64>,
    den: Vec<f64>,
    timebase: T,
}

/// Coefficients that do not form a transfer function.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidTransferFunction {
    /// A list of coefficients is empty.
    #[error("{polynomial} has no coefficients; give at least one, highest power first")]
    Empty {
        /// `num` or `den`.
        polynomial: &'static str,
    },
    /// A coefficient is infinite or not a number.
    #[error("{polynomial}[{index}] is {coefficient}; every coefficient must be finite")]
    NotFinite {
        /// `num` or `den`.
        polynomial: &'static str,
        /// Index in the list, from 0.
        index: usize,
        /// The coefficient.
        coefficient: f64,
    },
    /// The denominator's highest power has coefficient zero.
    #[error(
        "den[0] is 0; drop the leading zeros, the first coefficient belongs to the highest power"
    )]
    LeadingZero,
    /// The numerator's degree is higher than the denominator's.
    #[error(
        "num has degree {num} and den only {den}: it is not causal; add poles (a derivative needs \
         a filter)"
    )]
    Improper {
        /// Degree of the numerator.
        num: usize,
        /// Degree of the denominator.
        den: usize,
    },
    /// Two systems with different sample times were put in series.
    #[error("the two systems have different sample times; discretise both with the same h")]
    Timebases,
}

impl<T: Timebase> TransferFunction<T> {
    /// num/den, both highest power first. Leading zeros of `num` are dropped.
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] if a list is empty, a coefficient is not finite, `den` starts with
    /// zero, or the function is not proper.
    pub fn try_new(
        num: impl Into<Vec<f64>>,
        den: impl Into<Vec<f64>>,
        timebase: T,
    ) -> Result<Self, InvalidTransferFunction> {
        let (num, den) = (num.into(), den.into());
        for (polynomial, coefficients) in [("num", &num), ("den", &den)] {
            if coefficients.is_empty() {
                return Err(InvalidTransferFunction::Empty { polynomial });
            }
            if let Some(index) = coefficients.iter().position(|c| !c.is_finite()) {
                let coefficient = coefficients[index];
                return Err(InvalidTransferFunction::NotFinite {
                    polynomial,
                    index,
                    coefficient,
                });
            }
        }
        if den[0] == 0.0 {
            return Err(InvalidTransferFunction::LeadingZero);
        }
        let num = trimmed(&num).to_vec();
        if num.len() > den.len() {
            return Err(InvalidTransferFunction::Improper {
                num: num.len() - 1,
                den: den.len() - 1,
            });
        }
        Ok(Self { num, den, timebase })
    }

    /// The numerator's coefficients, highest power first.
    #[must_use]
    pub fn num(&self) -> &[f64] {
        &self.num
    }

    /// The denominator's coefficients, highest power first.
    #[must_use]
    pub fn den(&self) -> &[f64] {
        &self.den
    }

    /// Continuous, or sampled every h.
    #[must_use]
    pub fn timebase(&self) -> T {
        self.timebase
    }

    /// The number of poles.
    #[must_use]
    pub fn order(&self) -> usize {
        self.den.len() - 1
    }

    /// The roots of the denominator, in no particular order.
    #[must_use]
    pub fn poles(&self) -> Vec<Complex<f64>> {
        roots(&self.den)
    }

    /// The roots of the numerator, in no particular order.
    #[must_use]
    pub fn zeros(&self) -> Vec<Complex<f64>> {
        roots(&self.num)
    }

    /// Whether every pole is stable.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.poles().into_iter().all(|p| self.timebase.is_stable(p))
    }

    /// The steady output for a constant input of one; infinite with an integrator.
    #[must_use]
    pub fn dc_gain(&self) -> f64 {
        let at = self.timebase.point(0.0);
        value(&self.num, at).re / value(&self.den, at).re
    }

    /// By its gain, zeros and poles, all real: gain (s - zero) .. / ((s - pole) ..).
    ///
    /// # Errors
    /// [`InvalidTransferFunction`] as [`try_new`](Self::try_new).
    pub fn try_from_roots(
        gain: f64,
        zeros: &[f64],
        poles: &[f64],
        timebase: T,
    ) -> Result<Self, InvalidTransferFunction> {
        let num: Vec<f64> = from_roots(zeros).iter().map(|x| gain * x).collect();
        Self::try_new(num, from_roots(poles), timebase)
    }

    /// The complex gain at a frequency in rad/s.
    #[must_use]
    pub fn frequency_response(&self, omega_rad_s: f64) -> Complex<f64> {
        let at = self.timebase.point(omega_rad_s);
        value(&self.num, at) / value(&self.den, at)
    }

    /// This system followed by `next`.
    ///
    /// # Errors
    /// [`InvalidTransferFunction::Timebases`] if their sample times differ.
    pub fn series(&self, next: &Self) -> Result<Self, InvalidTransferFunction> {
        if self.timebase != next.timebase {
            return Err(InvalidTransferFunction::Timebases);
        }
        Self::try_new(
            product(&self.num, &next.num),
            product(&self.den, &next.den),
            self.timebase,
        )
    }

    /// The loop closed around this system with unity negative feedback: L / (1 + L).
    ///
    /// # Errors
    /// [`InvalidTransferFunction::LeadingZero`] if 1 + L loses its highest power, that is, if the
    /// feed-through is exactly -1 and the algebraic loop has no solution.
    pub fn feedback(&self) -> Result<Self, InvalidTransferFunction> {
        Self::try_new(self.num.clone(), sum(&self.den, &self.num), self.timebase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timebase::Discrete;

    #[test]
    fn each_invalid_coefficient_list_is_named() {
        let refuse = |num: &[f64], den: &[f64]| {
            TransferFunction::try_new(num, den, Continuous)
                .expect_err("must be refused")
                .to_string()
        };
        assert!(refuse(&[], &[1.0]).starts_with("num has no coefficients"));
        assert!(refuse(&[1.0], &[1.0, f64::NAN]).starts_with("den[1] is NaN"));
        assert!(refuse(&[1.0], &[0.0, 1.0]).starts_with("den[0] is 0"));
        assert!(refuse(&[1.0, 0.0], &[1.0]).starts_with("num has degree 1 and den only 0"));
    }

    #[test]
    fn leading_zeros_of_the_numerator_do_not_count_as_degree() {
        let g = TransferFunction::try_new([0.0, 0.0, 4.0], [1.0, 2.0], Continuous)
            .expect("proper after trimming");
        assert_eq!((g.num(), g.dc_gain()), (&[4.0][..], 2.0));
    }

    #[test]
    fn a_sampled_system_has_its_dc_gain_at_one_and_turns_at_nyquist() {
        // 1/(z - 0.5) is 2 at z = 1 and -2/3 at z = -1.
        let h = Discrete::try_new(0.1).expect("positive");
        let g = TransferFunction::try_new([1.0], [1.0, -0.5], h).expect("valid");
        let nyquist = h.nyquist_rad_s().expect("sampled");
        assert!((g.dc_gain() - 2.0).abs() < 1e-15);
        assert!((g.frequency_response(nyquist) + 2.0 / 3.0).norm() < 1e-12);
        assert!(g.is_stable());
    }
}
