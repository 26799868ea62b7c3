//! Distributions of times, as quantile functions: from `u` in (0, 1) to nanoseconds.
//!
//! Every draw is an inverse-CDF transform of one uniform draw, with `libm`: the same seed gives the same bits
//! on every machine. What a law means for a link (level, stall) is described where it is used.

use std::sync::Arc;

use serde::Serialize;

use crate::special::{self, Tails};

/// Number of points of a computed quantile table. They are 0.036 apart on the logit scale, where
/// linear interpolation is off in a tail by 0.036^2 / 12 = 1e-4 of its scale.
const NODES: usize = 2049;
/// End of the table on the logit scale: ln(u / (1 - u)) of the smallest and the largest uniform draw
/// is -36.7 and 36.7.
const LOGIT_END: f64 = 37.0;
/// Number of cells over which a law's mean is summed; they cut off a fifty-thousandth of an
/// exponential tail.
const MEAN_CELLS: u32 = 20_000;

/// The form of a law, with its parameters in nanoseconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)] // The fields are the usual parameters of each law.
pub(crate) enum Form {
    /// Always the same value.
    Constant { value_ns: f64 },
    /// All values between two limits equally likely.
    Uniform { min_ns: f64, max_ns: f64 },
    /// The normal law; its user has to clip values below zero.
    Normal { mean_ns: f64, sd_ns: f64 },
    /// The exponential law.
    Exponential { mean_ns: f64 },
    /// The gamma law by its moments: shape (mean/sd)^2, scale sd^2/mean.
    Gamma { mean_ns: f64, sd_ns: f64 },
    /// The beta law between two limits, by its moments.
    Beta {
        min_ns: f64,
        max_ns: f64,
        mean_ns: f64,
        sd_ns: f64,
    },
    /// The Pareto law: P(X > x) = (scale / x)^shape from `scale_ns` on.
    Pareto { scale_ns: f64, shape: f64 },
    /// Points (probability, value) of the quantile function, joined by straight lines.
    Table { points: Vec<(f64, f64)> },
}

/// A law and the limits to which its values are clipped.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Law {
    form: Form,
    min_ns: f64,
    max_ns: f64,
    /// Mean of the clipped law.
    mean_ns: f64,
    #[serde(skip)]
    table: Arc<[(f64, f64)]>,
}

impl Law {
    /// A law with its values clipped to `min_ns..=max_ns`. The resolver has checked the parameters.
    pub(crate) fn new(form: Form, min_ns: f64, max_ns: f64) -> Self {
        let table = match &form {
            Form::Normal { mean_ns, sd_ns } => tabulate(
                |x| special::normal((x - mean_ns) / sd_ns),
                (mean_ns - 9.0 * sd_ns, mean_ns + 9.0 * sd_ns),
            ),
            Form::Gamma { mean_ns, sd_ns } => {
                let shape = (mean_ns / sd_ns) * (mean_ns / sd_ns);
                let scale = sd_ns * sd_ns / mean_ns;
                // The upper end: Q(shape, x) < 1e-17 for all shapes.
                let end = scale * (shape + 9.0 * shape.sqrt() + 40.0);
                tabulate(|x| special::gamma(shape, x / scale), (0.0, end))
            }
            Form::Beta {
                min_ns,
                max_ns,
                mean_ns,
                sd_ns,
            } => {
                let width = max_ns - min_ns;
                let mean = (mean_ns - min_ns) / width;
                let sd = sd_ns / width;
                let total = mean * (1.0 - mean) / (sd * sd) - 1.0;
                let (a, b) = (mean * total, (1.0 - mean) * total);
                tabulate(
                    |x| special::beta(a, b, (x - min_ns) / width),
                    (*min_ns, *max_ns),
                )
            }
            Form::Table { points } => points.as_slice().into(),
            _ => Arc::default(),
        };
        let mut law = Self {
            form,
            min_ns,
            max_ns,
            mean_ns: 0.0,
            table,
        };
        // The midpoint rule on the quantile function.
        let cell = |i: u32| law.quantile_ns((f64::from(i) + 0.5) / f64::from(MEAN_CELLS));
        law.mean_ns = (0..MEAN_CELLS).map(cell).sum::<f64>() / f64::from(MEAN_CELLS);
        law
    }

    /// The exponential law, unclipped.
    pub(crate) fn exponential(mean_ns: f64) -> Self {
        Self {
            form: Form::Exponential { mean_ns },
            min_ns: 0.0,
            max_ns: f64::INFINITY,
            mean_ns,
            table: Arc::default(),
        }
    }

    /// The least and the greatest value after clipping.
    pub(crate) fn limits_ns(&self) -> (f64, f64) {
        (self.min_ns, self.max_ns)
    }

    /// The law's form, before clipping.
    pub(crate) fn form(&self) -> &Form {
        &self.form
    }

    /// The quantile at `u` in the open interval (0, 1).
    pub(crate) fn quantile_ns(&self, u: f64) -> f64 {
        self.raw_ns(u).clamp(self.min_ns, self.max_ns)
    }

    /// The quantile before clipping.
    pub(crate) fn raw_ns(&self, u: f64) -> f64 {
        match &self.form {
            Form::Constant { value_ns } => *value_ns,
            Form::Uniform { min_ns, max_ns } => min_ns + u * (max_ns - min_ns),
            Form::Exponential { mean_ns } => -mean_ns * libm::log1p(-u),
            Form::Pareto { scale_ns, shape } => scale_ns * libm::pow(1.0 - u, -1.0 / shape),
            Form::Normal { .. } | Form::Gamma { .. } | Form::Beta { .. } | Form::Table { .. } => {
                interpolate(&self.table, u)
            }
        }
    }

    /// The greatest value that a draw can give.
    pub(crate) fn reach_ns(&self) -> f64 {
        self.quantile_ns(1.0 - f64::EPSILON / 2.0)
    }

    /// The least value that a draw can give.
    pub(crate) fn floor_ns(&self) -> f64 {
        self.quantile_ns(f64::EPSILON / 2.0)
    }

    /// Mean of the clipped law.
    pub(crate) fn mean_ns(&self) -> f64 {
        self.mean_ns
    }
}

/// Quantiles at probabilities evenly spaced on the logit scale, which resolves both tails equally;
/// all quantiles lie between `ends`.
fn tabulate(tails: impl Fn(f64) -> Tails, ends: (f64, f64)) -> Arc<[(f64, f64)]> {
    let mut low = ends.0;
    (0..NODES)
        .map(|node| {
            let logit = LOGIT_END * (2.0 * node as f64 / (NODES - 1) as f64 - 1.0);
            let below = 1.0 / (1.0 + libm::exp(-logit));
            let above = 1.0 / (1.0 + libm::exp(logit));
            // Compares the smaller tail, which has the significant digits.
            let excess = |x: f64| {
                let tails = tails(x);
                if below < above {
                    tails.below - below
                } else {
                    above - tails.above
                }
            };
            low = root(excess, low, ends.1);
            (below, low)
        })
        .collect()
}

/// The root of an increasing function between two points, by false position with the Illinois
/// correction, until the bracket is narrower than 1e-10 of the range.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const STEPS: usize = 200;
    let narrow = 1e-10 * (high - low).abs();
    let (mut f_low, mut f_high) = (f(low), f(high));
    let mut last_side = 0;
    for step in 0..STEPS {
        if f_low >= 0.0 {
            return low;
        }
        if f_high <= 0.0 || high - low <= narrow {
            return high;
        }
        // Every third step halves the bracket, so that a flat tail cannot stall the search.
        let x = if step % 3 == 2 {
            0.5 * (low + high)
        } else {
            (high * f_low - low * f_high) / (f_low - f_high)
        };
        let f_x = f(x);
        if f_x < 0.0 {
            (low, f_low) = (x, f_x);
            if last_side == -1 {
                f_high *= 0.5;
            }
            last_side = -1;
        } else {
            (high, f_high) = (x, f_x);
            if last_side == 1 {
                f_low *= 0.5;
            }
            last_side = 1;
        }
    }
    0.5 * (low + high)
}

/// Linear interpolation between the two points that enclose `u`.
fn interpolate(points: &[(f64, f64)], u: f64) -> f64 {
    let after = points.partition_point(|&(p, _)| p < u);
    match (
        after.checked_sub(1).and_then(|i| points.get(i)),
        points.get(after),
    ) {
        (Some(&(p0, x0)), Some(&(p1, x1))) => x0 + (x1 - x0) * ((u - p0) / (p1 - p0)),
        (Some(&(_, x)), None) | (None, Some(&(_, x))) => x,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(law: &Law) -> (f64, f64) {
        let n = 400_000;
        let values = (0..n).map(|i| law.quantile_ns((f64::from(i) + 0.5) / f64::from(n)));
        let (sum, squares) = values.fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
        let mean = sum / f64::from(n);
        (mean, (squares / f64::from(n) - mean * mean).sqrt())
    }

    #[test]
    fn tabulated_laws_have_the_moments_they_are_named_by() {
        // The table is accurate to about 2e-5, and the midpoint rule cuts the tails.
        let (mean_ns, sd_ns) = (5e6, 2e6);
        for form in [
            Form::Normal { mean_ns, sd_ns },
            Form::Gamma { mean_ns, sd_ns },
            Form::Gamma {
                mean_ns,
                sd_ns: 8e6,
            },
            Form::Beta {
                min_ns: 1e6,
                max_ns: 12e6,
                mean_ns,
                sd_ns,
            },
        ] {
            let want_sd = if let Form::Gamma { sd_ns, .. } = form {
                sd_ns
            } else {
                sd_ns
            };
            let law = Law::new(form, f64::NEG_INFINITY, f64::INFINITY);
            let (mean, sd) = moments(&law);
            assert!(
                (mean / mean_ns - 1.0).abs() < 2e-4,
                "{:?} mean {mean}",
                law.form()
            );
            assert!((sd / want_sd - 1.0).abs() < 5e-4, "{:?} sd {sd}", law.form);
        }
    }

    #[test]
    fn quantiles_never_fall() {
        for form in [
            Form::Gamma {
                mean_ns: 1e6,
                sd_ns: 3e6,
            },
            Form::Pareto {
                scale_ns: 1e6,
                shape: 1.5,
            },
            Form::Table {
                points: vec![(0.0, 1e6), (0.5, 1e6), (1.0, 9e6)],
            },
        ] {
            let law = Law::new(form, 0.0, 1e12);
            let mut last = 0.0;
            for i in 1..10_000 {
                let x = law.quantile_ns(f64::from(i) / 10_000.0);
                assert!(x >= last);
                last = x;
            }
        }
    }

    #[test]
    fn the_first_quantiles_are_the_same_on_every_machine() {
        let mut text = String::new();
        for form in [
            Form::Uniform {
                min_ns: 1e6,
                max_ns: 5e6,
            },
            Form::Exponential { mean_ns: 2e6 },
            Form::Normal {
                mean_ns: 9e6,
                sd_ns: 1e6,
            },
            Form::Gamma {
                mean_ns: 2e6,
                sd_ns: 3e6,
            },
            Form::Beta {
                min_ns: 0.0,
                max_ns: 8e6,
                mean_ns: 2e6,
                sd_ns: 1e6,
            },
            Form::Pareto {
                scale_ns: 1e6,
                shape: 2.5,
            },
        ] {
            let law = Law::new(form, 0.0, f64::INFINITY);
            let mut draws = crate::draws::Draws::new(42, b"up.level");
            let bits = (0..10).map(|i| format!("{:016x}", law.quantile_ns(draws.at(i)).to_bits()));
            text.push_str(&format!(
                "{:?}\n{}\n",
                law.form(),
                bits.collect::<Vec<_>>().join(" ")
            ));
        }
        insta::assert_snapshot!(text);
    }
}
