//! The part of a system that its inputs reach and its outputs show, and the modes that are left over.
//!
//! A zero that lies on a pole cancels it: the mode is there, but no loop around the system sees it. The parts
//! are told apart by Krylov's vectors B, AB, A²B, .. made orthogonal one by one (a staircase; P. Van Dooren,
//! 1981), in wide numbers and before sampling, so that a mode counts as cancelled if the numbers say so and not
//! if rounding does.

use nalgebra::Complex;

use crate::hessenberg::eigenvalues;
use crate::state_space::StateSpace;
use crate::timebase::Continuous;
use crate::wide::Wide;
use crate::wide::matrix::{Matrix, dot};

/// A mode of the plant that no loop around it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hidden {
    /// Its pole, rad/s; of two complex ones each is a mode of its own.
    pub pole: Complex<f64>,
    /// Whether it dies out when it is left alone.
    pub fate: Fate,
}

/// What becomes of a mode that is left alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It dies out.
    DiesOut,
    /// It stays, or drifts with what drives it: an integrator, an undamped oscillator.
    Stays,
    /// It grows, until the plant leaves its limits.
    Grows,
}

/// The matrices of the part that is reached and shown, and the rest's modes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Minimal {
    pub(crate) a: Matrix,
    pub(crate) b: Matrix,
    pub(crate) c: Matrix,
    pub(crate) hidden: Vec<Hidden>,
}

/// A vector that is new by less than this part is not new, for numbers that were given.
const NOTHING: f64 = 1e-27;

/// The same for a plant's numbers that were rounded when it was sampled, from (A - 1)/h.
///
/// Each entry of A is off by up to u = 2⁻⁵³ of it, so (A - 1)/h by up to ε = u |A|/|A - 1| of its norm (the largest
/// sum of a row). The staircase adds to that its own rounding alone, as it is exact for a system that is off by so
/// much (P. Van Dooren, 1981), which in wide numbers is nothing. A mode that the input reaches by a part r, and that
/// the output shows by as large a part, as in balanced coordinates (B. C. Moore, 1981), is r² of the response. The
/// numbers cannot tell it from one that is not there if that is less than ε; so if r < √ε.
fn rounded(a: &Matrix, h_s: f64) -> f64 {
    const UNIT: f64 = f64::EPSILON / 2.0;
    // What an input reaches at once is new, also where A is 1 and nothing of (A - 1)/h is known.
    const MOST: f64 = 0.5;
    let h = Wide::from(h_s);
    let moved = a.clone().each(|x| x * h);
    let whole = Matrix::identity(a.rows()).plus(&moved);
    (UNIT * whole.norm() / moved.norm()).sqrt().min(MOST)
}

impl Minimal {
    pub(crate) fn of(system: &StateSpace<Continuous>) -> Self {
        let (a, b, c) = (system.a(), system.b(), system.c());
        Self::with(a.into(), b.into(), c.into(), NOTHING)
    }

    /// Of a system that is sampled already, as (A - 1)/h, B/h and C. All of it, unless a mode that does not die out
    /// is cancelled: in rounded numbers a mode that is hardly reached looks like one that is not.
    pub(crate) fn sampled(a: Matrix, b: Matrix, c: Matrix, h_s: f64) -> Self {
        let mut seen = Self::with(a.clone(), b.clone(), c.clone(), rounded(&a, h_s));
        // From (z - 1)/h to whether |z| is below, at or above 1.
        const AT_ONE: f64 = 1e-9;
        for mode in &mut seen.hidden {
            let size = (1.0 + mode.pole * h_s).norm();
            mode.fate = match size - 1.0 {
                off if off > AT_ONE * h_s.max(1.0) => Fate::Grows,
                off if off < -AT_ONE * h_s.max(1.0) => Fate::DiesOut,
                _ => Fate::Stays,
            };
        }
        let die_out = seen.hidden.iter().all(|mode| mode.fate == Fate::DiesOut);
        if !die_out {
            return seen;
        }
        Self {
            a,
            b,
            c,
            hidden: Vec::new(),
        }
    }

    fn with(mut a: Matrix, mut b: Matrix, mut c: Matrix, nothing: f64) -> Self {
        balance(&mut a, &mut b, &mut c);
        let mut hidden = Vec::new();
        let (a, b, c) = reached((a, b, c), nothing, &mut hidden);
        let across = (a.transposed(), c.transposed(), b.transposed());
        let (a, c, b) = reached(across, nothing, &mut hidden);
        Self {
            a: a.transposed(),
            b: b.transposed(),
            c: c.transposed(),
            hidden,
        }
    }
}

/// Scales states by powers of two until rows and columns of A are about equally large (E. E. Osborne, 1960).
fn balance(a: &mut Matrix, b: &mut Matrix, c: &mut Matrix) {
    const ROUNDS: usize = 100;
    let n = a.rows();
    for _ in 0..ROUNDS {
        let mut is_balanced = true;
        for i in 0..n {
            let others = (0..n).filter(|j| *j != i);
            let size = |at: (usize, usize)| a[at].rounded().abs();
            let row: f64 = others.clone().map(|j| size((i, j))).sum();
            let column: f64 = others.map(|j| size((j, i))).sum();
            if row == 0.0 || column == 0.0 {
                continue;
            }
            // State i over 2^k divides its row and multiplies its column.
            let k = ((row / column).log2() / 2.0).round().clamp(-500.0, 500.0);
            if k == 0.0 {
                continue;
            }
            is_balanced = false;
            let factor = k.exp2();
            for j in 0..n {
                a[(i, j)] = a[(i, j)].scaled(1.0 / factor);
            }
            for j in 0..n {
                a[(j, i)] = a[(j, i)].scaled(factor);
            }
            for j in 0..b.columns() {
                b[(i, j)] = b[(i, j)].scaled(1.0 / factor);
            }
            for j in 0..c.rows() {
                c[(j, i)] = c[(j, i)].scaled(factor);
            }
        }
        if is_balanced {
            break;
        }
    }
}

/// The part of a system that its inputs reach; the modes of the rest are added to `hidden`.
fn reached(
    (a, b, c): (Matrix, Matrix, Matrix),
    nothing: f64,
    hidden: &mut Vec<Hidden>,
) -> (Matrix, Matrix, Matrix) {
    let n = a.rows();
    let size = a.norm();
    let mut basis: Vec<Vec<Wide>> = Vec::new();
    let mut waiting: std::collections::VecDeque<(Vec<Wide>, f64)> = (0..b.columns())
        .map(|j| b.column(j))
        .map(|column| (column.clone(), length(&column)))
        .collect();
    while let Some((vector, scale)) = waiting.pop_front() {
        if basis.len() == n {
            break;
        }
        let rest = across(vector, &basis);
        let left = length(&rest);
        if left > nothing * scale {
            let unit = over(rest, left);
            waiting.push_back((a.onto(&unit), size));
            basis.push(unit);
        }
    }
    if basis.len() == n {
        return (a, b, c);
    }
    let others = complement(n, &basis);
    let rest = Matrix::of_columns(n, &others);
    let block = rest.transposed().times(&a).times(&rest).rounded();
    // A pole of a block of several at one place is off by the root of the precision.
    let still = (1e-7 * block.norm()).max(10.0 * nothing.max(1e-20) * size);
    hidden.extend(eigenvalues(&block).into_iter().map(|pole| Hidden {
        pole,
        fate: match pole.re {
            re if re > still => Fate::Grows,
            re if re < -still => Fate::DiesOut,
            _ => Fate::Stays,
        },
    }));
    let basis = Matrix::of_columns(n, &basis);
    let back = basis.transposed();
    (
        back.times(&a).times(&basis),
        back.times(&b),
        c.times(&basis),
    )
}

fn length(vector: &[Wide]) -> f64 {
    dot(vector, vector).rounded().max(0.0).sqrt()
}

fn over(vector: Vec<Wide>, length: f64) -> Vec<Wide> {
    // First by a power of two, so that squares neither overflow nor vanish; then exactly.
    let power = (-length.log2().round()).exp2();
    let vector: Vec<Wide> = vector.into_iter().map(|x| x.scaled(power)).collect();
    let length = dot(&vector, &vector).sqrt();
    vector.into_iter().map(|x| x / length).collect()
}

/// What of a vector is across all of the basis; twice is enough.
fn across(mut vector: Vec<Wide>, basis: &[Vec<Wide>]) -> Vec<Wide> {
    for _ in 0..2 {
        for unit in basis {
            let along = dot(unit, &vector);
            for (x, u) in vector.iter_mut().zip(unit) {
                *x -= along * *u;
            }
        }
    }
    vector
}

/// Unit vectors across the basis and each other, as many as are missing.
fn complement(n: usize, basis: &[Vec<Wide>]) -> Vec<Vec<Wide>> {
    let mut all = basis.to_vec();
    while all.len() < n {
        let axes = (0..n).map(|i| {
            let mut axis = vec![Wide::ZERO; n];
            axis[i] = Wide::ONE;
            across(axis, &all)
        });
        let Some(longest) = axes.max_by(|a, b| length(a).total_cmp(&length(b))) else {
            break;
        };
        let long = length(&longest);
        all.push(over(longest, long));
    }
    all.split_off(basis.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::TransferFunction;

    fn hidden(num: &[f64], den: &[f64]) -> Vec<Hidden> {
        let g = TransferFunction::try_new(num, den, Continuous).expect("valid");
        Minimal::of(&StateSpace::from(&g)).hidden
    }

    #[test]
    fn a_zero_on_a_pole_hides_its_mode_and_one_beside_it_does_not() {
        let found = hidden(&[1.0, 0.0], &[1.0, 1.0, 0.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].fate, Fate::Stays);
        let found = hidden(&[1.0, 3.0], &[1.0, 6.0, 11.0, 6.0]);
        assert!((found[0].pole.re + 3.0).abs() < 1e-9 && found.len() == 1);
        assert_eq!(found[0].fate, Fate::DiesOut);
        assert_eq!(hidden(&[1.0, -1.0], &[1.0, 0.0, -1.0])[0].fate, Fate::Grows);
        assert!(hidden(&[1.0, 3.0001], &[1.0, 6.0, 11.0, 6.0]).is_empty());
        assert!(hidden(&[1.0], &[1.0, 0.0, 0.0]).is_empty());
    }

    #[test]
    fn poles_nine_decades_apart_are_all_seen() {
        // (s + 1e-3)(s + 1)(s + 1e6).
        assert!(hidden(&[1.0], &[1.0, 1_000_001.001, 1_001_000.001, 1000.0]).is_empty());
    }
}
