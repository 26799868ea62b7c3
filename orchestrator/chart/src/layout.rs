//! The layout of the page: lengths, all in points, and panels side by side.
//!
//! A chart of one column is 127 mm wide; any other is 180 mm wide, a journal's page. The height
//! follows from the content.

use crate::scene::Place;
use crate::text;

pub(crate) const TITLE_SIZE: f64 = 9.5;
pub(crate) const HEADING_SIZE: f64 = 8.5;
pub(crate) const LABEL_SIZE: f64 = 7.5;
pub(crate) const LEGEND_SIZE: f64 = 7.5;
pub(crate) const TICK_SIZE: f64 = 7.0;
pub(crate) const GUIDE_SIZE: f64 = 6.5;
pub(crate) const SOURCE_SIZE: f64 = 6.0;

/// Distance from one baseline to the next, in font sizes.
pub(crate) const LEADING: f64 = 1.25;

/// Margin on all sides.
pub(crate) const EDGE: f64 = 5.0;

/// Margin on the right, into which the last number of an axis may extend.
pub(crate) const RIGHT_EDGE: f64 = 10.0;

/// Gap between panels side by side, into which the last number of an axis may extend.
pub(crate) const GAP: f64 = 13.0;

/// Gap between rows of panels.
pub(crate) const ROW_GAP: f64 = 12.0;

/// Length of a tick.
pub(crate) const TICK: f64 = 3.0;

/// Width of a whole chart.
pub(crate) fn page_width(columns: usize) -> f64 {
    if columns <= 1 { 360.0 } else { 510.0 }
}

/// Width of a panel, with its numbers.
pub(crate) fn panel_width(columns: usize) -> f64 {
    let columns = columns.max(1) as f64;
    ((page_width(columns as usize) - EDGE - RIGHT_EDGE - (columns - 1.0) * GAP) / columns).max(40.0)
}

/// Height of the box between a panel's axes.
pub(crate) fn box_height(columns: usize) -> f64 {
    match columns {
        0 | 1 => 190.0,
        2 => 145.0,
        3 => 115.0,
        _ => 95.0,
    }
}

/// Width and height that a panel's box would have without numbers beside it.
pub(crate) fn largest_box(columns: usize) -> (f64, f64) {
    (panel_width(columns), box_height(columns))
}

/// The box between a panel's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Frame {
    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Converts a place in the unit square to one on the page.
    pub(crate) fn place(&self, at: Place) -> Place {
        (
            self.left + at.0 * self.width,
            self.bottom() - at.1 * self.height,
        )
    }

    pub(crate) fn places(&self, line: &[Place]) -> Vec<Place> {
        line.iter().map(|at| self.place(*at)).collect()
    }

    /// Whether the two overlap.
    pub(crate) fn overlaps(&self, other: &Frame) -> bool {
        self.left < other.right()
            && other.left < self.right()
            && self.top < other.bottom()
            && other.top < self.bottom()
    }

    pub(crate) fn contains(&self, place: Place) -> bool {
        (self.left..=self.right()).contains(&place.0)
            && (self.top..=self.bottom()).contains(&place.1)
    }
}

/// Arranges items of these widths in rows of at most `room`. Returns where each starts, as (x, row),
/// and the number of rows.
pub(crate) fn flow(widths: &[f64], gap: f64, room: f64) -> (Vec<(f64, usize)>, usize) {
    let (mut x, mut row) = (0.0, 0);
    let mut places = Vec::with_capacity(widths.len());
    for width in widths {
        if x > 0.0 && x + width > room {
            x = 0.0;
            row += 1;
        }
        places.push((x, row));
        x += width + gap;
    }
    let rows = if widths.is_empty() { 0 } else { row + 1 };
    (places, rows)
}

/// The largest font size up to `size` at which a text is no wider than `room`, but at least 5, which
/// can still be read.
pub(crate) fn fitting(content: &str, size: f64, room: f64) -> f64 {
    let width = text::width(content, size, false);
    if width <= room {
        size
    } else {
        (size * room / width).max(5.0)
    }
}
