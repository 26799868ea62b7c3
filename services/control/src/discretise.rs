//! From continuous to sampled systems.
//!
//! All three methods give the same standard form, next x = A x + B u and y = C x + D u, in which u
//! and y belong to the same tick. The results agree with scipy's `cont2discrete` matrix by matrix
//! (methods `backward_diff`, `zoh`, `bilinear`). There is no pre-warping.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::state_space::{InvalidStateSpace, StateSpace};
use crate::timebase::{Continuous, Discrete, InvalidSampleTime};

/// The substitution for s, or the assumption about the input between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// s = (z - 1) / (z h), as in the paper: `x_k = (I - hA)⁻¹ (x_(k-1) + h B u_k)`, `y_k = C x_k + D
    /// u_k`. The input of a tick acts within that tick, so D is not zero even if the continuous D is.
    BackwardEuler,
    /// The input is held between samples; exact at the samples for such an input.
    ZeroOrderHold,
    /// s = 2 (z - 1) / (h (z + 1)), the trapezoidal rule.
    Tustin,
}

/// Why a system cannot be sampled in this way.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidDiscretisation {
    /// The sample time is not a positive finite number.
    #[error(transparent)]
    SampleTime(#[from] InvalidSampleTime),
    /// A pole lies exactly at the pole of the substitution for s.
    #[error(
        "with h = {h_s} s the pole at {pole_rad_s} rad/s makes {method:?} singular; use another h or method"
    )]
    Singular {
        /// The method of discretisation.
        method: Method,
        /// The sample time in seconds.
        h_s: f64,
        /// The (real) pole, in rad/s.
        pole_rad_s: f64,
    },
    /// The dead time is not a whole number of samples, which the method cannot represent.
    #[error(
        "a dead time of {dead_time_ns} ns is not a multiple of h = {h_ns} ns, and {method:?} \
         handles whole samples only; use zero-order hold, or another h"
    )]
    DeadTime {
        /// The dead time in ns.
        dead_time_ns: u64,
        /// The sample time in ns.
        h_ns: u64,
        /// The method of discretisation.
        method: Method,
    },
    /// The result overflows, as e^(Ah) does for a very unstable plant and a long h.
    #[error("the sampled system overflows with h = {h_s} s; use a shorter h")]
    Overflow {
        /// The sample time in seconds.
        h_s: f64,
    },
}

/// A pole this close (relative to its size) to the pole of the substitution counts as equal: any
/// closer, and the inverse loses all its sixteen digits.
const SINGULAR: f64 = 1e-12;

/// Samples `system` every `h_s` seconds.
///
/// # Errors
/// [`InvalidDiscretisation`] if h is not finite and positive, if I - hA (backward Euler) or I - hA/2
/// (Tustin) is singular, or if the result overflows.
pub fn discretise(
    system: &StateSpace<Continuous>,
    method: Method,
    h_s: f64,
) -> Result<StateSpace<Discrete>, InvalidDiscretisation> {
    let timebase = Discrete::try_new(h_s)?;
    let (a, b, c, d) = match method {
        Method::BackwardEuler => bilinear(system, method, h_s, 1.0)?,
        Method::Tustin => bilinear(system, method, h_s, 0.5)?,
        Method::ZeroOrderHold => {
            let (a, b) = held(system, h_s);
            (a, b, system.c().clone(), system.d().clone())
        }
    };
    StateSpace::try_new(a, b, c, d, timebase).map_err(|error| match error {
        InvalidStateSpace::NotFinite { .. } => InvalidDiscretisation::Overflow { h_s },
        InvalidStateSpace::Shape { .. } | InvalidStateSpace::Signals { .. } => {
            unreachable!("sampling keeps the shapes of a valid system")
        }
    })
}

type Matrices = (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DMatrix<f64>);

/// The generalised bilinear transform with weight `alpha` on the new sample: 1 is backward Euler,
/// 1/2 Tustin (G. Zhang, X. Chen and T. Chen, Int. J. Control 82, 2009).
fn bilinear(
    system: &StateSpace<Continuous>,
    method: Method,
    h_s: f64,
    alpha: f64,
) -> Result<Matrices, InvalidDiscretisation> {
    let n = system.order();
    let reach = alpha * h_s;
    let on_pole =
        |p: &nalgebra::Complex<f64>| (1.0 - p * reach).norm() <= SINGULAR * (p * reach).norm();
    let singular = |pole_rad_s| InvalidDiscretisation::Singular {
        method,
        h_s,
        pole_rad_s,
    };
    if let Some(pole) = system.poles().iter().find(|p| on_pole(p)) {
        return Err(singular(pole.re));
    }
    let identity = DMatrix::<f64>::identity(n, n);
    let inverse = (&identity - system.a() * reach)
        .try_inverse()
        .ok_or_else(|| singular(1.0 / reach))?;
    let a = &inverse * (&identity + system.a() * ((1.0 - alpha) * h_s));
    let b = &inverse * system.b() * h_s;
    let c = system.c() * &inverse;
    let d = system.d() + (system.c() * &b) * alpha;
    Ok((a, b, c, d))
}

/// The exponential of [A B; 0 0] h has the sampled A and B in its upper blocks (C. Van Loan, 1978). NaN if the
/// tenth power overflows, by which the exponential is scaled.
pub(crate) fn held(system: &StateSpace<Continuous>, h_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, m) = (system.order(), system.inputs());
    let mut block = DMatrix::<f64>::zeros(n + m, n + m);
    block
        .view_mut((0, 0), (n, n))
        .copy_from(&(system.a() * h_s));
    block
        .view_mut((0, n), (n, m))
        .copy_from(&(system.b() * h_s));
    let square = &block * &block;
    let fourth = &square * &square;
    let tenth = &fourth * &fourth * square;
    let exponential = if tenth.iter().all(|x| x.is_finite()) {
        block.exp()
    } else {
        block * f64::NAN
    };
    (
        exponential.view((0, 0), (n, n)).into_owned(),
        exponential.view((0, n), (n, m)).into_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::TransferFunction;

    fn lag(pole_rad_s: f64) -> StateSpace {
        StateSpace::from(
            &TransferFunction::try_new([1.0], [1.0, -pole_rad_s], Continuous).expect("valid"),
        )
    }

    #[test]
    fn backward_euler_of_one_lag_is_the_paper_s_substitution_by_hand() {
        // 1/(s + 2) with s = (z - 1)/(z h), h = 0.1: h z / ((1 + 2h) z - 1), so the pole is 1/1.2 and
        // the immediate gain h/1.2.
        let sampled = discretise(&lag(-2.0), Method::BackwardEuler, 0.1).expect("regular");
        let g = sampled.transfer_function().expect("finite");
        assert!((g.poles()[0].re - 1.0 / 1.2).abs() < 1e-15);
        assert!((sampled.d0() - 0.1 / 1.2).abs() < 1e-16);
        assert!(g.zeros()[0].norm() < 1e-15);
    }

    #[test]
    fn a_sample_time_that_puts_a_pole_on_the_substitution_is_refused() {
        // The pole at +5 rad/s makes I - hA singular for h = 0.2 and I - hA/2 for h = 0.4.
        for (method, h_s) in [(Method::BackwardEuler, 0.2), (Method::Tustin, 0.4)] {
            let error = discretise(&lag(5.0), method, h_s).expect_err("singular");
            assert!(
                matches!(error, InvalidDiscretisation::Singular { .. }),
                "{error}"
            );
            assert!(discretise(&lag(5.0), Method::ZeroOrderHold, h_s).is_ok());
        }
    }

    #[test]
    fn no_sample_time_but_a_positive_finite_one_is_accepted() {
        for h_s in [0.0, -0.001, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                discretise(&lag(-1.0), Method::ZeroOrderHold, h_s),
                Err(InvalidDiscretisation::SampleTime(_))
            ));
        }
    }

    #[test]
    fn an_exponential_that_overflows_is_an_error_and_not_infinity() {
        assert_eq!(
            discretise(&lag(1e6), Method::ZeroOrderHold, 1.0).expect_err("e^(10^6)"),
            InvalidDiscretisation::Overflow { h_s: 1.0 }
        );
    }
}
