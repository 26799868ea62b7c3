//! An axis before anything is drawn: its name, how its numbers are laid out, and from where to where.

use serde::Serialize;

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Its name with its unit: `time/s`.
    pub label: String,
    /// How its numbers are laid out.
    pub scale: Scale,
    /// From where to where; as the data need it if not given.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// As long as its data need it.
    #[must_use]
    pub fn new(label: &str, scale: Scale) -> Axis {
        Axis {
            label: label.to_owned(),
            scale,
            range: None,
        }
    }
}

/// How numbers are laid out on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Evenly spaced.
    Linear,
    /// By their powers of ten; what is not above zero is not drawn.
    Log,
}
