//! Diagonal lines over rectangles, for areas that have no colour of their own.
//!
//! The positions of the lines are fixed on the page, so that a line continues from one rectangle to
//! the next where they touch.

use std::collections::BTreeMap;

use crate::layout::Frame;
use crate::scene::Place;

/// Distance from one line to the next, along either side of the page.
const PITCH: f64 = 4.2;

/// Ends at most this far apart, in points, are the same.
const SAME: f64 = 0.01;

/// The parts of the lines that are within these rectangles.
pub(crate) fn hatch(rooms: &[Frame]) -> Vec<Vec<Place>> {
    // By the line's number n, with x + y = n · PITCH: the ranges of x that it covers.
    let mut parts: BTreeMap<i64, Vec<(f64, f64)>> = BTreeMap::new();
    for room in rooms {
        let first = ((room.left + room.top) / PITCH).ceil() as i64;
        let last = ((room.right() + room.bottom()) / PITCH).floor() as i64;
        for line in first..=last {
            let sum = line as f64 * PITCH;
            let from = room.left.max(sum - room.bottom());
            let to = room.right().min(sum - room.top);
            if from + SAME < to {
                parts.entry(line).or_default().push((from, to));
            }
        }
    }
    let mut lines = Vec::new();
    for (line, mut parts) in parts {
        let sum = line as f64 * PITCH;
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut joined: Vec<(f64, f64)> = Vec::new();
        for (from, to) in parts {
            match joined.last_mut() {
                Some(last) if from <= last.1 + SAME => last.1 = last.1.max(to),
                _ => joined.push((from, to)),
            }
        }
        let places = joined
            .iter()
            .map(|(from, to)| vec![(*from, sum - from), (*to, sum - to)]);
        lines.extend(places);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(left: f64, top: f64) -> Frame {
        Frame {
            left,
            top,
            width: 20.0,
            height: 10.0,
        }
    }

    #[test]
    fn lines_stay_within_and_slant() {
        let lines = hatch(&[room(7.0, 30.0)]);
        assert!(lines.len() > 5, "{lines:?}");
        for line in &lines {
            let [from, to] = line.as_slice() else {
                panic!("{line:?}");
            };
            assert!(((from.0 + from.1) - (to.0 + to.1)).abs() < 1e-9);
            for (x, y) in [from, to] {
                assert!((7.0 - 1e-9..=27.0 + 1e-9).contains(x), "{lines:?}");
                assert!((30.0 - 1e-9..=40.0 + 1e-9).contains(y), "{lines:?}");
            }
        }
    }

    #[test]
    fn rectangles_that_touch_are_hatched_as_one() {
        let whole = Frame {
            height: 20.0,
            ..room(7.0, 30.0)
        };
        let in_two = hatch(&[room(7.0, 30.0), room(7.0, 40.0)]);
        assert_eq!(in_two.len(), hatch(&[whole]).len());
    }
}
