//! Matrices of wide numbers: sums, products, and the integral of the exponential by which a plant is sampled.

use std::ops::{Index, IndexMut};

use nalgebra::DMatrix;

use super::Wide;

/// A matrix, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matrix {
    rows: usize,
    columns: usize,
    entries: Vec<Wide>,
}

impl Matrix {
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            entries: vec![Wide::ZERO; rows * columns],
        }
    }

    pub(crate) fn identity(n: usize) -> Self {
        let mut identity = Self::zeros(n, n);
        for i in 0..n {
            identity[(i, i)] = Wide::ONE;
        }
        identity
    }

    /// A matrix with these columns, of `rows` entries each.
    pub(crate) fn of_columns(rows: usize, columns: &[Vec<Wide>]) -> Self {
        let mut matrix = Self::zeros(rows, columns.len());
        for (j, column) in columns.iter().enumerate() {
            for (i, entry) in column.iter().enumerate() {
                matrix[(i, j)] = *entry;
            }
        }
        matrix
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    pub(crate) fn row(&self, row: usize) -> &[Wide] {
        &self.entries[row * self.columns..(row + 1) * self.columns]
    }

    pub(crate) fn column(&self, column: usize) -> Vec<Wide> {
        (0..self.rows).map(|row| self[(row, column)]).collect()
    }

    pub(crate) fn transposed(&self) -> Self {
        let mut transposed = Self::zeros(self.columns, self.rows);
        for i in 0..self.rows {
            for j in 0..self.columns {
                transposed[(j, i)] = self[(i, j)];
            }
        }
        transposed
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for k in 0..self.columns {
                let factor = self[(i, k)];
                if factor.is_zero() {
                    continue;
                }
                for j in 0..other.columns {
                    product[(i, j)] += factor * other[(k, j)];
                }
            }
        }
        product
    }

    pub(crate) fn onto(&self, vector: &[Wide]) -> Vec<Wide> {
        (0..self.rows)
            .map(|row| dot(self.row(row), vector))
            .collect()
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        for (entry, other) in self.entries.iter_mut().zip(&other.entries) {
            *entry += *other;
        }
        self
    }

    /// Every entry times or over a number.
    pub(crate) fn each(mut self, of: impl Fn(Wide) -> Wide) -> Self {
        for entry in &mut self.entries {
            *entry = of(*entry);
        }
        self
    }

    /// This matrix with the columns of `other` beside its own.
    pub(crate) fn beside(&self, other: &Self) -> Self {
        let columns: Vec<Vec<Wide>> = (0..self.columns)
            .map(|j| self.column(j))
            .chain((0..other.columns).map(|j| other.column(j)))
            .collect();
        Self::of_columns(self.rows, &columns)
    }

    /// The largest sum of the magnitudes of a row.
    pub(crate) fn norm(&self) -> f64 {
        let rows = (0..self.rows).map(|row| self.row(row));
        let sums = rows.map(|row| row.iter().map(|x| x.rounded().abs()).sum());
        sums.fold(0.0, f64::max)
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.entries.iter().all(|x| x.rounded().is_finite())
    }

    pub(crate) fn rounded(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows, self.columns, |i, j| self[(i, j)].rounded())
    }
}

impl From<&DMatrix<f64>> for Matrix {
    fn from(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let mut wide = Self::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                wide[(i, j)] = matrix[(i, j)].into();
            }
        }
        wide
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = Wide;

    fn index(&self, (row, column): (usize, usize)) -> &Wide {
        &self.entries[row * self.columns + column]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut Wide {
        &mut self.entries[row * self.columns + column]
    }
}

pub(crate) fn dot(a: &[Wide], b: &[Wide]) -> Wide {
    a.iter()
        .zip(b)
        .fold(Wide::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// The mean of e^(A s) for s from 0 to `t_s`: (e^(A t) - 1) / (A t), also where A cannot be inverted. What a
/// held input adds to the state is this times t B, and e^(A t) is 1 + A t times this, without a difference of
/// numbers that are nearly equal.
pub(crate) fn held(a: &Matrix, t_s: f64) -> Matrix {
    // 0.5^24 / 25! is 4e-33.
    const TERMS: u32 = 24;
    const LARGEST: f64 = 0.5;
    let n = a.rows();
    let x = a.clone().each(|entry| entry * t_s.into());
    let doublings = (x.norm() / LARGEST).log2().ceil().clamp(0.0, 2_000.0) as i32;
    let shrink = 2f64.powi(-doublings.min(1_000)) * 2f64.powi(-(doublings - 1_000).max(0));
    let x = x.each(|entry| entry.scaled(shrink));
    // 1 + x/2 (1 + x/3 (1 + ..)).
    let mut mean = Matrix::identity(n);
    for k in (2..=TERMS).rev() {
        let over = Wide::from(f64::from(k));
        mean = Matrix::identity(n).plus(&x.times(&mean).each(|entry| entry / over));
    }
    // The mean over twice the time is this mean times (1 + e^x) / 2.
    let mut x = x;
    for _ in 0..doublings {
        let half = x.times(&mean).each(|entry| entry.scaled(0.5));
        mean = mean.times(&Matrix::identity(n).plus(&half));
        x = x.each(|entry| entry.scaled(2.0));
    }
    mean
}
