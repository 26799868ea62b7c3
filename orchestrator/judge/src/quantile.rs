//! Quantiles of measured values, of how many values one may speak of one, and to how many digits one is told: the
//! rules for all of this crate.

use crate::limit::BEYOND;

/// Whether so many values are enough for the quantile `q`: [`BEYOND`] of them lie on its thin side.
pub(crate) fn is_enough(count: usize, q: f64) -> bool {
    count as f64 * q.min(1.0 - q) >= BEYOND
}

/// The quantile `q` of values in any order, which it changes; `None` if they are too few for it.
pub(crate) fn quantile(values: &mut [f64], q: f64) -> Option<f64> {
    let rank = (q * values.len() as f64) as usize;
    if rank >= values.len() || !is_enough(values.len(), q) {
        return None;
    }
    // A tenth of the time that sorting them takes.
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// A measured value to the three decimals that are written.
pub(crate) fn thousandths(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// How many values are greater than `limit`.
pub(crate) fn beyond(values: &[f64], limit: f64) -> usize {
    values.iter().filter(|value| **value > limit).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_needs_more_than_one_value_on_its_thin_side() {
        let of = |count: u32, q| {
            let mut values: Vec<f64> = (0..count).rev().map(f64::from).collect();
            quantile(&mut values, q)
        };
        assert_eq!(of(1, 0.1), None);
        assert_eq!(of(14, 0.1), None);
        assert_eq!(of(15, 0.1), Some(1.0));
        assert_eq!(of(3, 0.5), Some(1.0));
        assert_eq!(of(149, 0.99), None);
        assert_eq!(of(150, 0.99), Some(148.0));
        assert_eq!(of(0, 0.5), None);
    }

    #[test]
    fn values_at_a_limit_are_not_beyond_it() {
        assert_eq!(beyond(&[1.0, 2.0, 2.0, 3.0], 2.0), 1);
        assert_eq!(beyond(&[], 2.0), 0);
    }
}
