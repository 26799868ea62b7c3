//! An axis before anything is drawn: its name, its scale and its range.

use serde::Serialize;

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Its name with its unit: `time/s`.
    pub label: String,
    /// How numbers are spaced on it.
    pub scale: Scale,
    /// Its range; `None` for the range of the data.
    pub range: Option<(f64, f64)>,
    /// Names at 0, 1, 2 and so on in place of numbers, on the horizontal axis.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

impl Axis {
    /// An axis with the range of its data.
    #[must_use]
    pub fn new(label: &str, scale: Scale) -> Axis {
        Axis {
            label: label.to_owned(),
            scale,
            range: None,
            names: Vec::new(),
        }
    }
}

/// A value this many times the next smaller one dwarfs it.
const DWARFS: f64 = 5.0;

/// Values over this ratio are told apart on a logarithmic axis only.
const WIDE: f64 = 1000.0;

/// At most one value of this many is left beyond the range.
const OF: usize = 8;

impl Axis {
    /// An axis on which these values can be told apart, whatever they are.
    ///
    /// Where one value, or one of eight, dwarfs the others and is farther from them than they are from each
    /// other, the range ends above the others: marks at the edge of the panel tell what is beyond. Values
    /// above zero that differ by three powers of ten have a logarithmic axis.
    #[must_use]
    pub fn telling(label: &str, values: impl IntoIterator<Item = f64>) -> Axis {
        let finite = values.into_iter().filter(|value| value.is_finite());
        let mut values: Vec<f64> = finite.collect();
        values.sort_by(f64::total_cmp);
        let [least, .., last] = values[..] else {
            return Axis::new(label, Scale::Linear);
        };
        // Quotients, since a product could overflow.
        let stands_out = |at: &usize| {
            let (most, next) = (values[at - 1], values[*at]);
            most > 0.0 && next / most >= DWARFS && (least <= 0.0 || next / most > most / least)
        };
        let beyond = (values.len() / OF).max(1).min(values.len() / 3);
        let first_beyond = (values.len() - beyond..values.len()).find(stands_out);
        let most = first_beyond.map_or(last, |at| values[at - 1]);
        let is_wide = least > 0.0 && most / least >= WIDE;
        // Some room above, in which the marks are.
        let low = if is_wide { least / 1.2 } else { least.min(0.0) };
        Axis {
            label: label.to_owned(),
            scale: if is_wide { Scale::Log } else { Scale::Linear },
            range: first_beyond.map(|_| (low, most * 1.2)),
            names: Vec::new(),
        }
    }
}

/// How numbers are spaced on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Evenly spaced.
    Linear,
    /// Logarithmic; values that are not above zero are not drawn.
    Log,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_tells_values_apart() {
        let axis = |values: &[f64]| {
            let axis = Axis::telling("y", values.iter().copied());
            (
                axis.scale,
                axis.range.map(|(low, high)| (low, high.round())),
            )
        };
        let linear = (Scale::Linear, None);
        assert_eq!(axis(&[]), linear);
        assert_eq!(axis(&[3.0]), linear);
        assert_eq!(axis(&[0.0, 0.0, 0.0, 7.0]), linear);
        assert_eq!(axis(&[10.0, 12.0, f64::NAN, 37.0]), linear);
        // Of two values, neither is the one that stands out.
        assert_eq!(axis(&[1.0, 1e6]), (Scale::Log, None));
        assert_eq!(
            axis(&[10.0, 1e12, 37.0, 12.0]),
            (Scale::Linear, Some((0.0, 44.0)))
        );
        assert_eq!(
            axis(&[-5.0, 1e12, 37.0, 12.0]),
            (Scale::Linear, Some((-5.0, 44.0)))
        );
        // The largest is no farther from the others than these are from each other.
        assert_eq!(axis(&[1.0, 10.0, 100.0, 1e4]), (Scale::Log, None));
        assert_eq!(
            axis(&[0.1, 10.0, 37.0, 1e12]),
            (Scale::Linear, Some((0.0, 44.0)))
        );
        assert_eq!(
            axis(&[6.0, 10.0, 1e4, 1e12]),
            (Scale::Log, Some((5.0, 12_000.0)))
        );
        // Two of sixteen.
        let mut many = vec![10.0; 14];
        many.extend([1e3, 1e6]);
        assert_eq!(axis(&many), (Scale::Linear, Some((0.0, 12.0))));
    }
}
