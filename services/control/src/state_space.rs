//! State space: x' = A x + B u (or the next x), y = C x + D u.
//!
//! One input and one output, or two; transfer functions and margins are of the first input and output.

use nalgebra::{Complex, DMatrix};
use thiserror::Error;

use crate::polynomial::{roots, sum};
use crate::signals::Signals;
use crate::timebase::{Continuous, Timebase};
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// A, B, C and D of a system with n states, m inputs and p outputs: n×n, n×m, p×n and p×m.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace<T: Timebase = Continuous> {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    timebase: T,
}

/// Matrices that do not form a system.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidStateSpace {
    /// Their shapes do not match.
    #[error(
        "A is {}x{}, B {}x{}, C {}x{} and D {}x{}; with n states, m inputs and p outputs they must be n x n, \
         n x m, p x n and p x m", a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1
    )]
    Shape {
        /// Rows and columns of A.
        a: (usize, usize),
        /// Of B.
        b: (usize, usize),
        /// Of C.
        c: (usize, usize),
        /// Of D.
        d: (usize, usize),
    },
    /// There are more inputs or outputs than [`Signals`] has, or none.
    #[error("there are {inputs} inputs and {outputs} outputs; a system has one or two of each")]
    Signals {
        /// Columns of B.
        inputs: usize,
        /// Rows of C.
        outputs: usize,
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
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
        timebase: T,
    ) -> Result<Self, InvalidStateSpace> {
        let (n, inputs, outputs) = (a.nrows(), d.ncols(), d.nrows());
        if a.ncols() != n || b.shape() != (n, inputs) || c.shape() != (outputs, n) {
            let [a, b, c, d] = [&a, &b, &c, &d].map(DMatrix::shape);
            return Err(InvalidStateSpace::Shape { a, b, c, d });
        }
        if !(1..=Signals::MOST).contains(&inputs) || !(1..=Signals::MOST).contains(&outputs) {
            return Err(InvalidStateSpace::Signals { inputs, outputs });
        }
        let entries = [("A", &a), ("B", &b), ("C", &c), ("D", &d)];
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
        self.a.nrows()
    }

    /// The number of inputs: 1 or 2.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.d.ncols()
    }

    /// The number of outputs: 1 or 2.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.d.nrows()
    }

    /// Whether it has one input and one output.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.d.shape() == (1, 1)
    }

    /// The state matrix A, n×n.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// B, a column for each input.
    #[must_use]
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    /// C, a row for each output.
    #[must_use]
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// D, the feed-through.
    #[must_use]
    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }

    /// The feed-through from the first input to the first output.
    #[must_use]
    pub fn d0(&self) -> f64 {
        self.d[(0, 0)]
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

    /// The behaviour from the first input to the first output as num/den: C adj(sI - A) B + D det(sI - A)
    /// over det(sI - A).
    ///
    /// # Errors
    /// [`InvalidTransferFunction::NotFinite`] if a coefficient overflows.
    pub fn transfer_function(&self) -> Result<TransferFunction<T>, InvalidTransferFunction> {
        let (den, adjugate) = resolvent(&self.a);
        let strictly_proper: Vec<f64> = adjugate
            .iter()
            .map(|m| (self.c.row(0) * m * self.b.column(0))[0])
            .collect();
        let feed_through: Vec<f64> = den.iter().map(|x| self.d0() * x).collect();
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
        let b = DMatrix::from_fn(n, 1, |row, _| f64::from(u8::from(row == 0)));
        let c = DMatrix::from_fn(1, n, |_, column| num[column + 1] - d * den[column + 1]);
        Self {
            a,
            b,
            c,
            d: DMatrix::from_element(1, 1, d),
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
        assert_eq!(ss.d0(), 0.5);
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
        assert_eq!((ss.order(), ss.d0()), (0, 3.0));
        assert_eq!(ss.transfer_function().expect("finite").dc_gain(), 3.0);
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused_with_all_of_them() {
        let error = StateSpace::try_new(
            DMatrix::zeros(2, 2),
            DMatrix::zeros(3, 1),
            DMatrix::zeros(1, 2),
            DMatrix::zeros(1, 1),
            Continuous,
        )
        .expect_err("B is too long");
        assert_eq!(
            error,
            InvalidStateSpace::Shape {
                a: (2, 2),
                b: (3, 1),
                c: (1, 2),
                d: (1, 1)
            }
        );
        let three = StateSpace::try_new(
            DMatrix::zeros(1, 1),
            DMatrix::zeros(1, 1),
            DMatrix::zeros(3, 1),
            DMatrix::zeros(3, 1),
            Continuous,
        );
        let signals = InvalidStateSpace::Signals {
            inputs: 1,
            outputs: 3,
        };
        assert_eq!(three.expect_err("three outputs"), signals);
    }
}
