//! The distribution functions of the normal, gamma and beta laws, both tails.
//!
//! Only what a quantile table needs: not a library of special functions. Based on `libm`, so that
//! every machine gets the same bits.

use libm::{exp, lgamma, log};

/// Relative size of a term at which a series or continued fraction counts as converged.
const DONE: f64 = 1e-15;
/// More terms than any law needs that the lint accepts.
const TERMS: usize = 100_000;
/// Replaces zero in a denominator of Lentz's method.
const TINY: f64 = 1e-300;

/// Probabilities below and above a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tails {
    pub(crate) below: f64,
    pub(crate) above: f64,
}

/// Standard normal law.
pub(crate) fn normal(x: f64) -> Tails {
    let half = |x: f64| 0.5 * libm::erfc(x * core::f64::consts::FRAC_1_SQRT_2);
    Tails {
        below: half(-x),
        above: half(x),
    }
}

/// Gamma law of the given shape, scale 1: the regularised incomplete gamma functions P and Q, by the
/// series DLMF 8.7.1 below the mean and by the continued fraction DLMF 8.9.2 above it.
pub(crate) fn gamma(shape: f64, x: f64) -> Tails {
    if x <= 0.0 {
        return Tails {
            below: 0.0,
            above: 1.0,
        };
    }
    let front = exp(shape * log(x) - x - lgamma(shape));
    if x < shape + 1.0 {
        let (mut term, mut sum) = (1.0 / shape, 1.0 / shape);
        for n in 1..TERMS {
            term *= x / (shape + n as f64);
            sum += term;
            if term < sum * DONE {
                break;
            }
        }
        let below = (front * sum).min(1.0);
        Tails {
            below,
            above: 1.0 - below,
        }
    } else {
        let fraction = lentz(x + 1.0 - shape, |n| {
            let n = n as f64;
            (n * (shape - n), x + 2.0 * n + 1.0 - shape)
        });
        let above = (front / fraction).min(1.0);
        Tails {
            below: 1.0 - above,
            above,
        }
    }
}

/// Beta law on (0, 1): the regularised incomplete beta function, by the continued fraction DLMF
/// 8.17.22 on the side where it converges fast.
pub(crate) fn beta(a: f64, b: f64, x: f64) -> Tails {
    if x > (a + 1.0) / (a + b + 2.0) {
        let mirrored = beta_below(b, a, 1.0 - x);
        return Tails {
            below: 1.0 - mirrored,
            above: mirrored,
        };
    }
    let below = beta_below(a, b, x);
    Tails {
        below,
        above: 1.0 - below,
    }
}

fn beta_below(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * libm::log1p(-x)) / a;
    let fraction = lentz(1.0, |n| {
        let m = (n / 2) as f64;
        let numerator = if n % 2 == 0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    });
    (front / fraction).min(1.0)
}

/// The continued fraction b0 + a1/(b1 + a2/(b2 + ...)), by the modified Lentz
/// method; `term(n)` gives `(a_n, b_n)`.
fn lentz(b0: f64, term: impl Fn(usize) -> (f64, f64)) -> f64 {
    let guard = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut value = guard(b0);
    let (mut c, mut d) = (value, 0.0);
    for n in 1..TERMS {
        let (a, b) = term(n);
        d = 1.0 / guard(b + a * d);
        c = guard(b + a / c);
        value *= c * d;
        if (c * d - 1.0).abs() < DONE {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(got: f64, want: f64) {
        assert!(
            (got - want).abs() < 1e-12 * want.abs().max(1e-3),
            "{got} {want}"
        );
    }

    #[test]
    fn a_gamma_of_shape_one_is_exponential() {
        for x in [0.01, 0.5, 1.9, 2.1, 30.0] {
            near(gamma(1.0, x).above, exp(-x));
        }
    }

    #[test]
    fn a_gamma_of_shape_two_has_its_closed_form() {
        // P(2, x) = 1 - (1 + x) e^-x.
        for x in [0.1, 1.0, 2.9, 3.1, 20.0] {
            near(gamma(2.0, x).above, (1.0 + x) * exp(-x));
        }
    }

    #[test]
    fn beta_has_its_closed_forms() {
        // I_x(2, 3) = 6x^2 - 8x^3 + 3x^4, and I_x(1, 1) = x.
        for x in [0.05_f64, 0.3, 0.42, 0.44, 0.9] {
            near(
                beta(2.0, 3.0, x).below,
                6.0 * x.powi(2) - 8.0 * x.powi(3) + 3.0 * x.powi(4),
            );
            near(beta(1.0, 1.0, x).above, 1.0 - x);
        }
    }

    #[test]
    fn the_normal_law_has_its_known_points() {
        // Abramowitz and Stegun, tables 26.1 and 26.2.
        near(normal(1.0).below, 0.841_344_746_068_542_9);
        near(normal(3.0).above, 0.001_349_898_031_630_094_6);
    }
}
