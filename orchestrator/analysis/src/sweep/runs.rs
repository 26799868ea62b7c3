//! The runs of a point taken together: how many were stable, and the medians of their figures.

use crate::statistics::median;

use super::row::Row;
use plan::sweep::Sweep;

/// A measure that is mapped and compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Time until y stays within 2 % of the reference, ms.
    Settling,
    /// Overshoot beyond the reference, % of it.
    Overshoot,
    /// Integral of the absolute error.
    Iae,
    /// Integral of e² + rho u².
    Cost,
}

impl Measure {
    /// All measures.
    pub const ALL: [Measure; 4] = [
        Measure::Settling,
        Measure::Overshoot,
        Measure::Iae,
        Measure::Cost,
    ];

    /// Its name in the name of a file.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Measure::Settling => "settling",
            Measure::Overshoot => "overshoot",
            Measure::Iae => "iae",
            Measure::Cost => "cost",
        }
    }

    /// Its name with its unit.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Measure::Settling => "settling/ms",
            Measure::Overshoot => "overshoot/%",
            Measure::Iae => "integral of |e|/s",
            Measure::Cost => "integral of e² + rho u²/s",
        }
    }
}

/// The runs of a point. A figure is the median over all its runs; a run that is unstable or lacks the
/// figure counts as infinite, worse than any other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointRuns {
    /// Number of runs.
    pub runs: u32,
    /// Number of stable runs.
    pub stable: u32,
    medians: [f64; Measure::ALL.len()],
}

impl PointRuns {
    /// The runs of all points of a sweep, in order; `runs` is 0 for points without a row.
    #[must_use]
    pub fn all(sweep: &Sweep, rows: &[Row]) -> Vec<PointRuns> {
        let mut of_point = vec![Vec::new(); sweep.grid.points()];
        for row in rows {
            if let Some(rows) = of_point.get_mut(row.run.point) {
                rows.push(*row);
            }
        }
        of_point.iter().map(|rows| PointRuns::of(rows)).collect()
    }

    /// The runs of one point, by their rows.
    #[must_use]
    pub fn of(rows: &[Row]) -> PointRuns {
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let medians = Measure::ALL.map(|measure| {
            let values = rows.iter().map(|row| {
                let figures = &row.figures;
                let figure = match measure {
                    Measure::Settling => figures.settling_ms,
                    Measure::Overshoot => figures.overshoot_pct,
                    Measure::Iae => figures.iae_s,
                    Measure::Cost => figures.cost_s,
                };
                figure.filter(|_| figures.stable).unwrap_or(f64::INFINITY)
            });
            middle(&values.collect::<Vec<f64>>())
        });
        PointRuns {
            runs: count(rows.len()),
            stable: count(rows.iter().filter(|row| row.figures.stable).count()),
            medians,
        }
    }

    /// A figure; infinite if at least half of the runs have none.
    #[must_use]
    pub fn figure(&self, measure: Measure) -> f64 {
        // `medians` is in the order of `Measure::ALL`, which is that of the variants.
        self.medians[measure as usize]
    }

    /// Whether more than half of its runs were stable.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        2 * self.stable > self.runs
    }
}

/// The median; infinite without values.
pub(crate) fn middle(values: &[f64]) -> f64 {
    median(values).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_figure_is_worse_than_any() {
        assert_eq!(middle(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(middle(&[1.0, 2.0]), 1.5);
        assert_eq!(middle(&[1.0, f64::INFINITY]), f64::INFINITY);
        assert_eq!(middle(&[1.0, 2.0, f64::INFINITY]), 2.0);
        assert_eq!(middle(&[]), f64::INFINITY);
    }
}
