//! Why a loop does not just hold, in words for tables and pages.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::silence::Silence;

/// Why a loop does not just hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// More overshoot than is asked, % of the step.
    Overshoot(f64),
    /// Having been in its band, y left it: when, s from the step, and by how much, in units of y.
    Left {
        /// When it left last, s from the step.
        at_s: f64,
        /// The greatest error from then on.
        error: f64,
    },
    /// A greater input than is asked, in units of u.
    Effort(f64),
    /// The error at the end is beyond the band; the greatest of the last fifth, in units of y.
    Outside(f64),
    /// Nobody commanded the plant any more.
    Silence(Silence),
    /// The error grows.
    Grows,
    /// y ends farther from r than it began; how far, in units of y.
    Away(f64),
    /// y left its limits: when, s from the step, and to what value.
    Limits {
        /// When, s from the step.
        at_s: f64,
        /// The first value beyond them.
        y: f64,
    },
    /// y is no finite number from this time on, s from the step.
    NotFinite(f64),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Overshoot(pct) => write!(f, "overshoot {pct:.0} %"),
            Reason::Left { at_s, error } => {
                write!(
                    f,
                    "left its band at {at_s:.2} s, by up to {}",
                    short(*error)
                )
            }
            Reason::Effort(u) => write!(f, "an input of {}", short(*u)),
            Reason::Outside(error) => write!(f, "still off by {} at the end", short(*error)),
            Reason::Silence(silence) => silence.fmt(f),
            Reason::Grows => f.write_str("its error grows"),
            Reason::Away(error) => write!(f, "off by {} at the end", short(*error)),
            // Nothing that the loop did: it was so when the loop began.
            Reason::Limits { at_s: 0.0, y } => {
                write!(f, "was beyond its limits from the start, y = {}", short(*y))
            }
            Reason::Limits { at_s, y } => {
                write!(f, "left its limits at {at_s:.2} s, y = {}", short(*y))
            }
            Reason::NotFinite(at_s) => write!(f, "y is no finite number from {at_s:.2} s on"),
        }
    }
}

/// Three significant digits, however small: the errors of a good loop are.
fn short(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude != 0.0 && !(1e-4..1e6).contains(&magnitude) {
        return format!("{x:.1e}");
    }
    let exponent = if magnitude == 0.0 {
        0.0
    } else {
        magnitude.log10().floor()
    };
    let decimals = (2 - exponent as i32).clamp(0, 6) as usize;
    format!("{x:.decimals$}")
}
