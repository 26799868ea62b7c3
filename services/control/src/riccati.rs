//! The algebraic Riccati equation of sampled systems: it gives the gains of an optimal regulator and,
//! by duality, those of a Kalman filter.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::hessenberg::eigenvalues;

/// The equation has no stabilising solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "the Riccati equation has no stabilising solution: an unstable mode is not controllable or not \
     observable; give weights above zero, or another model"
)]
pub struct NoSolution;

/// Most doublings; 60 of them look 2^60 samples ahead.
const DOUBLINGS: usize = 60;
/// A change smaller than this part of the solution is rounding.
const CONVERGED: f64 = 1e-13;

/// The stabilising X of X = A'XA - A'XB (R + B'XB)⁻¹ B'XA + Q, by the doubling of E. K.-W. Chu, H.-Y.
/// Fan and W.-W. Lin (2005): each round looks twice as far ahead. Shapes: A and Q n×n, B n×m; `r` is the
/// diagonal of R.
///
/// # Errors
/// [`NoSolution`] if it does not converge, or an entry of `r` is not positive.
pub(crate) fn solve(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &[f64],
) -> Result<DMatrix<f64>, NoSolution> {
    let n = a.nrows();
    if !r.iter().all(|r| r.is_finite() && *r > 0.0) {
        return Err(NoSolution);
    }
    let identity = DMatrix::identity(n, n);
    let original = a;
    // B R⁻¹ B', input by input.
    let mut weighted = DMatrix::zeros(n, n);
    for (column, r) in b.column_iter().zip(r) {
        weighted += column * column.transpose() / *r;
    }
    let (mut a, mut g, mut h) = (a.clone(), weighted, q.clone());
    for _ in 0..DOUBLINGS {
        let w = (&identity + &g * &h).try_inverse().ok_or(NoSolution)?;
        let by_w = &a * &w;
        let next_g = &g + &by_w * &g * a.transpose();
        let growth = a.transpose() * &h * &w * &a;
        let next_a = &by_w * &a;
        h += &growth;
        (a, g) = (next_a, next_g);
        if !h.iter().all(|x| x.is_finite()) {
            return Err(NoSolution);
        }
        if growth.norm() <= CONVERGED * h.norm() {
            // Symmetric except for rounding.
            let x = (&h + h.transpose()) / 2.0;
            let gains = gains(original, b, &x, r)?;
            let poles = eigenvalues(&(original - b * gains));
            // An uncontrollable mode converges too, but to a solution that does not stabilise it.
            return if poles.len() == n && poles.iter().all(|pole| pole.norm() < 1.0) {
                Ok(x)
            } else {
                Err(NoSolution)
            };
        }
    }
    Err(NoSolution)
}

/// (R + B'XB)⁻¹ B'XA: the gains that belong to a solution, a row for each input.
///
/// # Errors
/// [`NoSolution`] if R + B'XB cannot be inverted.
pub(crate) fn gains(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    x: &DMatrix<f64>,
    r: &[f64],
) -> Result<DMatrix<f64>, NoSolution> {
    let reach = b.transpose() * x;
    let scale = scale(&reach * b, r);
    match scale.as_slice() {
        [scale] => Ok(reach * a / *scale),
        _ => Ok(scale.try_inverse().ok_or(NoSolution)? * reach * a),
    }
}

/// X C' (R + CXC')⁻¹: by duality, what a Kalman filter with the covariance X corrects its state by, a column
/// for each output.
///
/// # Errors
/// [`NoSolution`] if R + CXC' cannot be inverted.
pub(crate) fn corrections(
    c: &DMatrix<f64>,
    x: &DMatrix<f64>,
    r: &[f64],
) -> Result<DMatrix<f64>, NoSolution> {
    let scale = scale(c * x * c.transpose(), r);
    let reach = x * c.transpose();
    match scale.as_slice() {
        [scale] => Ok(reach / *scale),
        _ => Ok(reach * scale.try_inverse().ok_or(NoSolution)?),
    }
}

/// A matrix with `r` added to its diagonal.
fn scale(mut matrix: DMatrix<f64>, r: &[f64]) -> DMatrix<f64> {
    for (i, r) in r.iter().enumerate() {
        matrix[(i, i)] += r;
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scalar_equation_has_the_root_of_its_quadratic() {
        // a = b = q = r = 1: x = x - x²/(1 + x) + 1, so x² - x - 1 = 0, whose root is the golden ratio.
        let one = DMatrix::from_element(1, 1, 1.0);
        let x = solve(&one, &one, &one, &[1.0]).expect("stabilisable")[0];
        assert!((x - f64::midpoint(1.0, 5f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn a_mode_that_grows_and_is_not_reached_has_no_solution() {
        let a = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1.2, 0.5]));
        let b = DMatrix::from_column_slice(2, 1, &[0.0, 1.0]);
        assert_eq!(
            solve(&a, &b, &DMatrix::identity(2, 2), &[1.0]),
            Err(NoSolution)
        );
        assert_eq!(
            solve(&a, &b, &DMatrix::identity(2, 2), &[0.0]),
            Err(NoSolution)
        );
    }
}
