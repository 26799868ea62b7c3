//! A loop by its own steps, many at a time: the growth of what is left after some round trips.
//!
//! The loop is stepped in time with its delay as a line of outputs, so that a step costs what the states of plant and
//! law cost and nothing for the delay. Near the border its envelope changes by a millionth in a round trip, which no
//! one would wait for. So the states after each K steps span a space, made orthogonal as they come (W. E. Arnoldi,
//! 1951), and the K steps within it are a small matrix, whose eigenvalues converge to the largest factors by which the
//! loop's modes grow in K steps. It is how flows are told stable that can only be stepped (W. S. Edwards, L. S.
//! Tuckerman et al., 1994). Here are no frequency response and no roots of a polynomial.

use nalgebra::{Complex, DMatrix, DVector};

use super::Fate;
use super::system::open;
use crate::table::Drawn;

/// The loop's states, and the outputs that are under way, the oldest first.
struct Stepped {
    states: usize,
    outputs: usize,
    ticks: usize,
    /// What each state, and each oldest output, adds to the states and to the newest outputs.
    columns: Vec<Vec<f64>>,
}

impl Stepped {
    fn of(of: &Drawn, gain: f64, ticks: usize) -> Self {
        let (all, dead) = open(of, gain);
        let outputs = of.plant.model.outputs();
        let column = |j| (0..all.rows).map(|i| all.get(i, j).rounded()).collect();
        Self {
            states: all.rows - outputs,
            outputs,
            // What the plant delays its law may as well wait for.
            ticks: ticks + dead,
            columns: (0..all.columns).map(column).collect(),
        }
    }

    /// So many steps; `seen` is told the states and outputs of each.
    fn run(&self, x: &mut [f64], line: &mut [f64], steps: usize, mut seen: impl FnMut(&[f64])) {
        let (n, p) = (self.states, self.outputs);
        let mut next = vec![0.0; n + p];
        let mut at = 0;
        for _ in 0..steps {
            next[..n].copy_from_slice(x);
            next[n..].fill(0.0);
            for (of, column) in x.iter().chain(&line[at..at + p]).zip(&self.columns) {
                for (sum, part) in next.iter_mut().zip(column) {
                    *sum += part * of;
                }
            }
            x.copy_from_slice(&next[..n]);
            line[at..at + p].copy_from_slice(&next[n..]);
            seen(&next);
            at = (at + p) % line.len();
        }
        line.rotate_left(at);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a_parts, b_parts) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a_parts.remainder().iter().zip(b_parts.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in a_parts.zip(b_parts) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn subtract(from: &mut [f64], factor: f64, of: &[f64]) {
    for (x, y) in from.iter_mut().zip(of) {
        *x -= factor * y;
    }
}

/// Numbers between -1 and 1 that are the same in each run (G. Marsaglia's xorshift, 2003).
fn noise() -> impl FnMut() -> f64 {
    let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        bits ^= bits << 13;
        bits ^= bits >> 7;
        bits ^= bits << 17;
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// The space of the states after each K steps.
struct Krylov {
    basis: Vec<Vec<f64>>,
    /// Columns of the small matrix, each with the length of what was new below.
    small: Vec<Vec<f64>>,
    /// By what each state is taken, so that all are about as large as the outputs.
    weights: Vec<f64>,
    steps: usize,
}

impl Krylov {
    /// From what is left of outputs at random, of all frequencies. What the plant's input does not reach stays at rest.
    fn start(of: &Stepped, steps: usize) -> Self {
        const FIRST: usize = 2;
        let (n, p) = (of.states, of.outputs);
        let (mut x, mut line) = (vec![0.0; n], vec![0.0; of.ticks * p]);
        let (mut noise, mut slow) = (noise(), vec![0.0; p]);
        let part = (of.ticks as f64).sqrt().recip();
        for y in line.chunks_mut(p) {
            for (y, slow) in y.iter_mut().zip(&mut slow) {
                *slow += part * noise();
                *y = *slow + part * noise();
            }
        }
        let mut most = vec![0.0_f64; n + p];
        of.run(&mut x, &mut line, FIRST * steps, |seen| {
            for (most, x) in most.iter_mut().zip(seen) {
                *most = most.max(x.abs());
            }
        });
        let long = (of.ticks as f64).sqrt() * most[n..].iter().fold(0.0_f64, |a, b| a.max(*b));
        let weight = |most: &f64| if *most > 0.0 { long / most } else { 1.0 };
        let weights: Vec<f64> = most[..n].iter().map(weight).collect();
        let mut first: Vec<f64> = x.iter().zip(&weights).map(|(x, w)| x * w).collect();
        first.extend(line);
        let length = dot(&first, &first).sqrt();
        first.iter_mut().for_each(|x| *x /= length);
        Self {
            basis: vec![first],
            small: Vec::new(),
            weights,
            steps,
        }
    }

    /// K steps more; whether there was anything new.
    fn grow(&mut self, of: &Stepped) -> bool {
        let Some(newest) = self.basis.last() else {
            return false;
        };
        let (x, line) = newest.split_at(of.states);
        let mut x: Vec<f64> = x.iter().zip(&self.weights).map(|(x, w)| x / w).collect();
        let mut line = line.to_vec();
        of.run(&mut x, &mut line, self.steps, |_| {});
        let mut next: Vec<f64> = x.iter().zip(&self.weights).map(|(x, w)| x * w).collect();
        next.extend(line);
        let before = dot(&next, &next).sqrt();
        let mut column = vec![0.0; self.basis.len()];
        // Twice is enough.
        for _ in 0..2 {
            for (along, unit) in column.iter_mut().zip(&self.basis) {
                let part = dot(unit, &next);
                subtract(&mut next, part, unit);
                *along += part;
            }
        }
        let length = dot(&next, &next).sqrt();
        column.push(length);
        self.small.push(column);
        let is_new = length.is_finite() && length > 1e-14 * before;
        next.iter_mut().for_each(|x| *x /= length);
        self.basis.push(next);
        is_new
    }

    /// The largest factors by which what the outputs show grows in K steps, and how far each may be off.
    fn factors(&self, of: &Stepped) -> Option<Vec<(f64, f64)>> {
        // So many of the largest; with two of each, as of a pair of poles.
        const MOST: usize = 16;
        // With a smaller part than this in the outputs a mode is hidden, and the part rounding.
        const SEEN: f64 = 1e-3;
        let m = self.small.len();
        let small = DMatrix::from_fn(m, m, |i, j| self.small[j].get(i).copied().unwrap_or(0.0));
        let below = self.small.last().and_then(|c| c.last()).copied()?;
        let mut found: Vec<Complex<f64>> = nalgebra::Schur::try_new(small.clone(), 1e-15, 10_000)?
            .complex_eigenvalues()
            .iter()
            .copied()
            .filter(|x| x.im >= 0.0)
            .collect();
        found.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        found.truncate(MOST);
        let factors = found.into_iter().filter_map(|factor| {
            let mode = vector(&small, factor)?;
            let off = below * mode[m - 1].norm();
            let mut seen = 0.0;
            let mut all = 0.0;
            for i in 0..self.basis[0].len() {
                let parts = self.basis.iter().zip(mode.iter());
                let part: Complex<f64> = parts.map(|(unit, x)| x * unit[i]).sum();
                all += part.norm_sqr();
                if i >= of.states {
                    seen += part.norm_sqr();
                }
            }
            (seen > SEEN * SEEN * all).then_some((factor.norm(), off))
        });
        Some(factors.collect())
    }
}

/// The eigenvector of length 1, by inverse iteration.
fn vector(of: &DMatrix<f64>, value: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let m = of.nrows();
    let beside = value + Complex::from(1e-15 * (1.0 + value.norm()));
    let mut shifted = of.map(Complex::from);
    for i in 0..m {
        shifted[(i, i)] -= beside;
    }
    let solver = shifted.lu();
    let mut vector = DVector::from_element(m, Complex::from(1.0));
    for _ in 0..3 {
        vector = solver.solve(&vector)?;
        let length = vector.norm();
        if !length.is_finite() {
            return None;
        }
        vector.unscale_mut(length);
    }
    Some(vector)
}

/// What becomes of the loop, as the largest factors say, twice alike.
pub(super) fn by_krylov(of: &Drawn, gain: f64, ticks: usize, most: usize) -> Fate {
    // The sizes of the space at which it is asked.
    const ASKED: [usize; 11] = [8, 12, 16, 22, 30, 40, 52, 66, 84, 106, 130];
    // An estimate of how far a factor is off may itself be off by as much, where modes are not across each other.
    const DOUBT: f64 = 10.0;
    // What rounding in a round trip is.
    const ROUNDING: f64 = 1e-12;
    let stepped = Stepped::of(of, gain, ticks);
    // A round trip, in which all that is under way is used, or a part of the slowest swing.
    let slowest = of
        .slowest_rad_s()
        .map_or(0.0, |w| 0.5 / (w * of.h_ns as f64 / 1e9));
    let mut steps = stepped.ticks.max(slowest as usize);
    let mut spent = 0;
    while spent + steps * ASKED[0] < most {
        let mut krylov = Krylov::start(&stepped, steps);
        let mut last = Fate::Open;
        for size in ASKED {
            let mut is_new = true;
            while is_new && krylov.small.len() < size {
                is_new = krylov.grow(&stepped);
                spent += steps;
            }
            let Some(factors) = krylov.factors(&stepped) else {
                return Fate::Open;
            };
            let off = |(factor, off): &(f64, f64)| (factor - 1.0, DOUBT * off + ROUNDING);
            let now = if factors.iter().map(off).any(|(over, doubt)| over > doubt) {
                Fate::Grows
            } else if factors
                .first()
                .map(off)
                .is_some_and(|(over, doubt)| -over > doubt)
            {
                Fate::DiesOut
            } else {
                Fate::Open
            };
            if now != Fate::Open && (now == last || !is_new) {
                return now;
            }
            last = now;
            if !is_new || spent > most {
                break;
            }
        }
        steps *= 4;
    }
    Fate::Open
}
