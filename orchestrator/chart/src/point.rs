//! A point of a series as it is drawn: its numbers, and its place in the panel.

use crate::scene::Place;

/// A point that is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// Its x and y.
    pub(crate) value: (f64, f64),
    /// Lower and upper end of its interval.
    pub(crate) band: Option<(f64, f64)>,
    /// Its place in the panel: (0, 0) is the bottom left corner, (1, 1) the top right.
    pub(crate) at: Place,
    /// Whether there is a gap in the line before it.
    pub(crate) after_gap: bool,
}
