//! x' = A x + B u, y = C x as a function of the complex frequency: C (v - A)⁻¹ B, and the angle of det(v - A).
//!
//! A has zeros below its first subdiagonal, so that a frequency costs n² operations. All is done in wide numbers.

use nalgebra::{Complex, DMatrix};

use crate::wide::matrix::Matrix;
use crate::wide::{Wide, WideComplex};

/// A system without feed-through, with A in Hessenberg form.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Hessenberg {
    a: Matrix,
    b: Matrix,
    c: Matrix,
}

/// The response at a frequency.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solved {
    /// C (v - A)⁻¹ B. An entry that is only rounding is 0.
    pub(crate) gain: DMatrix<Complex<f64>>,
    /// det(v - A) over its magnitude.
    pub(crate) turn: Complex<f64>,
}

/// An output smaller than this part of the terms it is the sum of is rounding.
const ROUNDING: f64 = 1e-27;

impl Hessenberg {
    /// The same system in states for which A has that form, by eliminations with pivots (J. H. Wilkinson, 1965).
    pub(crate) fn new(mut a: Matrix, mut b: Matrix, mut c: Matrix) -> Self {
        let n = a.rows();
        for k in 0..n.saturating_sub(2) {
            let below = k + 1;
            let size = |row: usize| a[(row, k)].rounded().abs();
            let Some(pivot) = (below..n).max_by(|p, q| size(*p).total_cmp(&size(*q))) else {
                continue;
            };
            if a[(pivot, k)].is_zero() {
                continue;
            }
            exchange_rows(&mut a, pivot, below);
            exchange_columns(&mut a, pivot, below);
            exchange_rows(&mut b, pivot, below);
            exchange_columns(&mut c, pivot, below);
            for row in below + 1..n {
                let factor = a[(row, k)] / a[(below, k)];
                if factor.is_zero() {
                    continue;
                }
                subtract_row(&mut a, row, below, factor);
                a[(row, k)] = Wide::ZERO;
                subtract_row(&mut b, row, below, factor);
                add_column(&mut a, below, row, factor);
                add_column(&mut c, below, row, factor);
            }
        }
        Self { a, b, c }
    }

    pub(crate) fn order(&self) -> usize {
        self.a.rows()
    }

    /// The eigenvalues of A, to the precision of `f64`; none if they cannot be found.
    pub(crate) fn poles(&self) -> Vec<Complex<f64>> {
        eigenvalues(&self.a.rounded())
    }

    /// The response at `v`; `None` at a pole.
    pub(crate) fn at(&self, v: Complex<f64>) -> Option<Solved> {
        let (n, inputs) = (self.a.rows(), self.b.columns());
        let width = n + inputs;
        // v - A with B beside it, row by row.
        let mut m = vec![WideComplex::ZERO; n * width];
        for i in 0..n {
            for j in i.saturating_sub(1)..n {
                m[i * width + j] = (-self.a[(i, j)]).into();
            }
            m[i * width + i] = m[i * width + i] + v.into();
            for j in 0..inputs {
                m[i * width + n + j] = self.b[(i, j)].into();
            }
        }
        let mut turn = Complex::new(1.0, 0.0);
        for k in 0..n {
            if k + 1 < n {
                let (here, next) = (m[k * width + k].size(), m[(k + 1) * width + k].size());
                if next > here {
                    for j in k..width {
                        m.swap(k * width + j, (k + 1) * width + j);
                    }
                    turn = -turn;
                }
            }
            let pivot = m[k * width + k];
            let rounded = pivot.rounded();
            let size = rounded.norm();
            if !(size > 0.0 && size.is_finite()) {
                return None;
            }
            turn *= rounded / size;
            if k + 1 < n && m[(k + 1) * width + k].size() > 0.0 {
                let factor = m[(k + 1) * width + k] / pivot;
                for j in k + 1..width {
                    m[(k + 1) * width + j] = m[(k + 1) * width + j] - factor * m[k * width + j];
                }
            }
        }
        let mut gain = DMatrix::zeros(self.c.rows(), inputs);
        for j in 0..inputs {
            let mut x = vec![WideComplex::ZERO; n];
            for i in (0..n).rev() {
                let rest = (i + 1..n).fold(m[i * width + n + j], |rest, k| {
                    rest - m[i * width + k] * x[k]
                });
                x[i] = rest / m[i * width + i];
            }
            for row in 0..self.c.rows() {
                gain[(row, j)] = sum(self.c.row(row), &x);
            }
        }
        gain.iter()
            .all(|g| g.is_finite())
            .then_some(Solved { gain, turn })
    }
}

/// c x, or 0 if that is only rounding.
fn sum(c: &[Wide], x: &[WideComplex]) -> Complex<f64> {
    let mut sum = WideComplex::ZERO;
    let mut sizes = 0.0;
    for (c, x) in c.iter().zip(x) {
        let term = *x * *c;
        sizes += term.size();
        sum = sum + term;
    }
    if sum.size() > ROUNDING * sizes {
        sum.rounded()
    } else {
        Complex::new(0.0, 0.0)
    }
}

/// The eigenvalues of a real matrix by shifted QR; none if that does not end.
pub(crate) fn eigenvalues(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    const ROUNDS: usize = 10_000;
    if a.nrows() == 0 {
        return Vec::new();
    }
    nalgebra::Schur::try_new(a.clone(), f64::EPSILON, ROUNDS)
        .map(|schur| schur.complex_eigenvalues().iter().copied().collect())
        .unwrap_or_default()
}

fn exchange_rows(m: &mut Matrix, p: usize, q: usize) {
    for j in 0..m.columns() {
        (m[(p, j)], m[(q, j)]) = (m[(q, j)], m[(p, j)]);
    }
}

fn exchange_columns(m: &mut Matrix, p: usize, q: usize) {
    for i in 0..m.rows() {
        (m[(i, p)], m[(i, q)]) = (m[(i, q)], m[(i, p)]);
    }
}

fn subtract_row(m: &mut Matrix, row: usize, other: usize, factor: Wide) {
    for j in 0..m.columns() {
        let part = factor * m[(other, j)];
        m[(row, j)] -= part;
    }
}

fn add_column(m: &mut Matrix, column: usize, other: usize, factor: Wide) {
    for i in 0..m.rows() {
        let part = factor * m[(i, other)];
        m[(i, column)] += part;
    }
}
