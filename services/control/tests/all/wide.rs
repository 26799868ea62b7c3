//! Matrices of some 32 digits for the tests, by other code than the crate's: a matrix is kept less the identity, so
//! that those of a step near z = 1 have all their digits where they differ from it.

use nalgebra::DMatrix;

/// The sum of two `f64`s that was not rounded.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Number {
    high: f64,
    low: f64,
}

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

fn halves(a: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

impl Number {
    fn of(high: f64, low: f64) -> Self {
        let (high, low) = two_sum(high, low);
        Self { high, low }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        let (high, off) = two_sum(self.high, other.high);
        let (low, more) = two_sum(self.low, other.low);
        let sum = Self::of(high, off + low);
        Self::of(sum.high, sum.low + more)
    }

    pub(crate) fn times(self, other: Self) -> Self {
        let product = self.high * other.high;
        let ((a, a_low), (b, b_low)) = (halves(self.high), halves(other.high));
        let off = ((a * b - product) + a * b_low + a_low * b) + a_low * b_low;
        Self::of(
            product,
            off + (self.high * other.low + self.low * other.high),
        )
    }

    pub(crate) fn over(self, other: Self) -> Self {
        let mut quotient = Self::default();
        let mut rest = self;
        for _ in 0..3 {
            let part = Self::from(rest.high / other.high);
            rest = rest.plus(part.times(other).negated());
            quotient = quotient.plus(part);
        }
        quotient
    }

    pub(crate) fn rounded(self) -> f64 {
        self.high
    }

    pub(crate) fn negated(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl From<f64> for Number {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

/// A matrix by rows, its higher and its lower digits apart.
#[derive(Debug, Clone)]
pub(crate) struct Matrix {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    high: Vec<f64>,
    low: Vec<f64>,
}

impl Matrix {
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        let zeros = vec![0.0; rows * columns];
        Self {
            rows,
            columns,
            high: zeros.clone(),
            low: zeros,
        }
    }

    pub(crate) fn identity(n: usize) -> Self {
        let mut identity = Self::zeros(n, n);
        for i in 0..n {
            identity.set(i, i, 1.0.into());
        }
        identity
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> Number {
        let at = i * self.columns + j;
        Number {
            high: self.high[at],
            low: self.low[at],
        }
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, to: Number) {
        let at = i * self.columns + j;
        (self.high[at], self.low[at]) = (to.high, to.low);
    }

    /// Adds a matrix, from row `i` and column `j` on.
    pub(crate) fn add(&mut self, i: usize, j: usize, other: &Self) {
        for row in 0..other.rows {
            for column in 0..other.columns {
                let sum = self.get(i + row, j + column).plus(other.get(row, column));
                self.set(i + row, j + column, sum);
            }
        }
    }

    pub(crate) fn part(&self, i: usize, j: usize, rows: usize, columns: usize) -> Self {
        let mut part = Self::zeros(rows, columns);
        for row in 0..rows {
            for column in 0..columns {
                part.set(row, column, self.get(i + row, j + column));
            }
        }
        part
    }

    pub(crate) fn scaled(mut self, by: Number) -> Self {
        for i in 0..self.rows {
            for j in 0..self.columns {
                self.set(i, j, self.get(i, j).times(by));
            }
        }
        self
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.add(0, 0, other);
        self
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let m = other.columns;
        let split: Vec<(f64, f64)> = other.high.iter().map(|x| halves(*x)).collect();
        let (upper, lower): (Vec<f64>, Vec<f64>) = split.into_iter().unzip();
        let mut product = Self::zeros(self.rows, m);
        let (mut sum, mut off) = (vec![0.0; m], vec![0.0; m]);
        for i in 0..self.rows {
            sum.fill(0.0);
            off.fill(0.0);
            for k in 0..self.columns {
                let Number { high: a, low: rest } = self.get(i, k);
                if a == 0.0 {
                    continue;
                }
                let (a_up, a_low) = halves(a);
                let row = k * m..(k + 1) * m;
                let factors = (other.high[row.clone()].iter().zip(&other.low[row.clone()]))
                    .zip(upper[row.clone()].iter().zip(&lower[row]));
                for ((sum, off), ((b, b_rest), (b_up, b_low))) in
                    sum.iter_mut().zip(&mut off).zip(factors)
                {
                    let part = a * b;
                    let more = ((a_up * b_up - part) + a_up * b_low + a_low * b_up) + a_low * b_low;
                    let (to, rounded) = two_sum(*sum, part);
                    *sum = to;
                    *off += rounded + (more + (a * b_rest + rest * b));
                }
            }
            for j in 0..m {
                product.set(i, j, Number::of(sum[j], off[j]));
            }
        }
        product
    }

    /// (1 + this)^2 - 1.
    pub(crate) fn squared(&self) -> Self {
        let square = self.times(self);
        self.clone().scaled(2.0.into()).plus(&square)
    }

    pub(crate) fn norm(&self) -> f64 {
        self.high.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// e^(this) - 1.
    pub(crate) fn exp_m1(&self) -> Self {
        // 0.25^22 / 23! is 2e-36.
        const TERMS: u32 = 22;
        let halvings = (self.norm().log2().ceil() as i32 + 2).clamp(0, 1000);
        let x = self.clone().scaled(2f64.powi(-halvings).into());
        let one = Self::identity(self.rows);
        let mut sum = one.clone();
        for k in (2..=TERMS).rev() {
            let over = Number::from(1.0).over(f64::from(k).into());
            sum = one.clone().plus(&x.times(&sum).scaled(over));
        }
        let mut exponential = x.times(&sum);
        for _ in 0..halvings {
            exponential = exponential.squared();
        }
        exponential
    }

    /// Scales by powers of two, which is exact, until the sizes of each state's row and column are alike; `into` has
    /// the states' inputs and `out_of` what their outputs show.
    pub(crate) fn balance(&mut self, into: &mut Self, out_of: &mut Self) {
        let n = self.rows;
        for _ in 0..100 {
            let mut is_done = true;
            for i in 0..n {
                let others = || (0..n).filter(|j| *j != i);
                let row: f64 = others().map(|j| self.get(i, j).high.abs()).sum();
                let column: f64 = others().map(|j| self.get(j, i).high.abs()).sum();
                if row == 0.0 || column == 0.0 {
                    continue;
                }
                let by = ((column / row).log2() / 2.0).round();
                if by == 0.0 {
                    continue;
                }
                is_done = false;
                let (up, down) = (2f64.powf(by), 2f64.powf(-by));
                for j in others() {
                    self.set(i, j, self.get(i, j).times(up.into()));
                    self.set(j, i, self.get(j, i).times(down.into()));
                }
                for j in 0..into.columns {
                    into.set(i, j, into.get(i, j).times(up.into()));
                }
                for j in 0..out_of.rows {
                    out_of.set(j, i, out_of.get(j, i).times(down.into()));
                }
            }
            if is_done {
                return;
            }
        }
    }
}

impl From<&DMatrix<f64>> for Matrix {
    fn from(of: &DMatrix<f64>) -> Self {
        let mut matrix = Self::zeros(of.nrows(), of.ncols());
        for i in 0..matrix.rows {
            for j in 0..matrix.columns {
                matrix.set(i, j, of[(i, j)].into());
            }
        }
        matrix
    }
}
