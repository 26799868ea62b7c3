//! State space with one input and one output: x' = A x + B u (or the next x), y = C x + D u.

use nalgebra::{Complex, DMatrix, DVector, RowDVector};
use thiserror::Error;

use crate::polynomial::{roots, sum};
use crate::timebase::{Continuous, Timebase};
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// A, B, C and D of a system with n states: n×n, n, n and a number.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace<T: Timebase = Continuous> {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: RowDVector<f64>,
    d: f64,
    timebase: T,
}

/// Matrices that do not form a system.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidStateSpace {
    /// Their shapes do not match.
    #[error(
        "A is {rows}x{columns}, B has {b} rows and C has {c} columns; with n states they must be n x n, n and n"
    )]
    Shape {
        /// Rows of A.
        rows: usize,
        /// Columns of A.
        columns: usize,
        /// Rows of B.
        b: usize,
        /// Columns of C.
        c: usize,
    },
    /// An entry is infinite or not a number.
    #[error("{matrix} has an entry that is not finite")]
    NotFinite {
        /// `A`, `B`, `C` or `D`.
        matrix: &'static str,
    },
}

impl<T: Timebase> StateSpace<T> {
    /// A system from its matrices. A system without states (a pure gain D) is valid too.
    ///
    /// # Errors
    /// [`InvalidStateSpace`] if shapes do not match or an entry is not finite.
    pub fn try_new(
        a: DMatrix<f64>,
        b: DVector<f64>,
        c: RowDVector<f64>,
        d: f64,
        timebase: T,
    ) -> Result<Self, InvalidStateSpace> {
        let (rows, columns) = a.shape();
        if rows != columns || b.len() != rows || c.len() != rows {
            return Err(InvalidStateSpace::Shape {
                rows,
                columns,
                b: b.len(),
                c: c.len(),
            });
        }
        let entries = [
            ("A", a.as_slice()),
            ("B", b.as_slice()),
            ("C", c.as_slice()),
            ("D", std::slice::from_ref(&d)),
        ];
        for (matrix, entries) in entries {
            if !entries.iter().all(|x| x.is_finite()) {
                return Err(InvalidStateSpace::NotFinite { matrix });
            }
        }
        Ok(Self {
            a,
            b,
            c,
            d,
            timebase,
        })
    }

    /// The number of states.
    #[must_use]
    pub fn order(&self) -> usize {
        self.b.len()
    }

    /// The state matrix A, n×n.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// B, a column of n.
    #[must_use]
    pub fn b(&self) -> &DVector<f64> {
        &self.b
    }

    /// C, a row of n.
    #[must_use]
    pub fn c(&self) -> &RowDVector<f64> {
        &self.c
    }

    /// D, the feed-through.
    #[must_use]
    pub fn d(&self) -> f64 {
        self.d
    }

    /// Continuous, or sampled every h.
    #[must_use]
    pub fn timebase(&self) -> T {
        self.timebase
    }

    /// The eigenvalues of A, in no particular order.
    #[must_use]
    pub fn poles(&self) -> Vec<Complex<f64>> {
        roots(&resolvent(&self.a).0)
    }

    /// The same input-output behaviour as num/den: C adj(sI - A) B + D det(sI - A) over det(sI - A).
    ///
    /// # Errors
    /// [`InvalidTransferFunction::NotFinite`] if a coefficient overflows.
    pub fn transfer_function(&self) -> Result<TransferFunction<T>, InvalidTransferFunction> {
        let (den, adjugate) = resolvent(&self.a);
        let strictly_proper: Vec<f64> = adjugate
            .iter()
            .map(|m| (&self.c * m * &self.b)[0])
            .collect();
        let feed_through: Vec<f64> = den.iter().map(|x| self.d * x).collect();
        TransferFunction::try_new(sum(&feed_through, &strictly_proper), den, self.timebase)
    }
}

/// The controllable canonical form of scipy's `tf2ss`: the first row of A is the negated denominator,
/// the entries below the diagonal are ones, and B is the first unit vector.
impl<T: Timebase> From<&TransferFunction<T>> for StateSpace<T> {
    fn from(system: &TransferFunction<T>) -> Self {
        let n = system.order();
        let lead = system.den()[0];
        let den: Vec<f64> = system.den().iter().map(|x| x / lead).collect();
        let mut num = vec![0.0; n + 1 - system.num().len()];
        num.extend(system.num().iter().map(|x| x / lead));
        let d = num[0];
        let a = DMatrix::from_fn(n, n, |row, column| match row {
            0 => -den[column + 1],
            _ => f64::from(u8::from(column + 1 == row)),
        });
        let b = DVector::from_fn(n, |row, _| f64::from(u8::from(row == 0)));
        let c = RowDVector::from_fn(n, |_, column| num[column + 1] - d * den[column + 1]);
        Self {
            a,
            b,
            c,
            d,
            timebase: system.timebase(),
        }
    }
}

/// det(λI - A) and adj(λI - A), a polynomial with matrix coefficients, both highest power first, by
/// the recursion of Faddeev and Le Verrier. It suits the few states of a plant; with tens of them it
/// loses accuracy.
fn resolvent(a: &DMatrix<f64>) -> (Vec<f64>, Vec<DMatrix<f64>>) {
    let n = a.nrows();
    let mut determinant = vec![1.0];
    let mut adjugate = Vec::with_capacity(n);
    let mut m = DMatrix::<f64>::identity(n, n);
    for k in 1..=n {
        let product = a * &m;
        let coefficient = -product.trace() / k as f64;
        determinant.push(coefficient);
        adjugate.push(std::mem::replace(
            &mut m,
            product + DMatrix::identity(n, n) * coefficient,
        ));
    }
    (determinant, adjugate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_canonical_form_leads_back_to_the_same_transfer_function() {
        // A biproper example: (2s² + 3s + 5) / (4s² + 8s + 12), so D = 0.5.
        let g = TransferFunction::try_new([2.0, 3.0, 5.0], [4.0, 8.0, 12.0], Continuous)
            .expect("valid");
        let ss = StateSpace::from(&g);
        assert_eq!(ss.d(), 0.5);
        let back = ss.transfer_function().expect("finite");
        for (found, given) in back
            .num()
            .iter()
            .zip(g.num())
            .chain(back.den().iter().zip(g.den()))
        {
            assert!((found * 4.0 - given).abs() < 1e-14);
        }
    }

    #[test]
    fn a_pure_gain_has_no_states() {
        let g = TransferFunction::try_new([6.0], [2.0], Continuous).expect("valid");
        let ss = StateSpace::from(&g);
        assert_eq!((ss.order(), ss.d()), (0, 3.0));
        assert_eq!(ss.transfer_function().expect("finite").dc_gain(), 3.0);
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused_with_all_of_them() {
        let error = StateSpace::try_new(
            DMatrix::zeros(2, 2),
            DVector::zeros(3),
            RowDVector::zeros(2),
            0.0,
            Continuous,
        )
        .expect_err("B is too long");
        assert_eq!(
            error,
            InvalidStateSpace::Shape {
                rows: 2,
                columns: 2,
                b: 3,
                c: 2
            }
        );
    }
}
