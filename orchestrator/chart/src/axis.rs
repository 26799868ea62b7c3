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

/// How numbers are spaced on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Evenly spaced.
    Linear,
    /// Logarithmic; values that are not above zero are not drawn.
    Log,
}
