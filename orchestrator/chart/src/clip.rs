//! Cuts lines and areas to the unit square, which is a panel from corner to corner.
//!
//! Cut shapes need no clipping paths, so the file has no numbered ids and nothing outside a panel.

use crate::scene::Place;

/// The parts of a line inside the unit square, by Liang and Barsky's method.
pub(crate) fn line(points: &[Place]) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = Vec::new();
    for (from, to) in points.iter().zip(points.iter().skip(1)) {
        let Some((a, b)) = segment(*from, *to) else {
            continue;
        };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&a) => part.push(b),
            _ => parts.push(vec![a, b]),
        }
    }
    parts
}

/// The part of a segment inside the unit square.
fn segment(from: Place, to: Place) -> Option<(Place, Place)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (towards, room) in [
        (-dx, from.0),
        (dx, 1.0 - from.0),
        (-dy, from.1),
        (dy, 1.0 - from.1),
    ] {
        if towards == 0.0 {
            if room < 0.0 {
                return None;
            }
            continue;
        }
        let crossing = room / towards;
        if towards < 0.0 {
            enter = enter.max(crossing);
        } else {
            leave = leave.min(crossing);
        }
    }
    let along = |t: f64| (unit(from.0 + t * dx), unit(from.1 + t * dy));
    // Ends that are inside stay as they are, so that joined segments still meet.
    let start = if enter == 0.0 { from } else { along(enter) };
    let end = if leave == 1.0 { to } else { along(leave) };
    (enter <= leave).then_some((start, end))
}

fn unit(value: f64) -> f64 {
    value.clamp(0.0, 1.0)
}

/// The part of an area inside the unit square, by Sutherland and Hodgman's method.
pub(crate) fn area(corners: &[Place]) -> Vec<Place> {
    let mut left: Vec<Place> = corners.to_vec();
    // Distance of a place from each side; negative outside.
    let sides: [fn(Place) -> f64; 4] = [|p| p.0, |p| 1.0 - p.0, |p| p.1, |p| 1.0 - p.1];
    for inside in sides {
        let mut cut = Vec::with_capacity(left.len());
        for (from, to) in left.iter().zip(left.iter().cycle().skip(1)) {
            let (a, b) = (inside(*from), inside(*to));
            if a >= 0.0 {
                cut.push(*from);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let t = a / (a - b);
                cut.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
            }
        }
        left = cut;
    }
    for corner in &mut left {
        *corner = (unit(corner.0), unit(corner.1));
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_the_square_is_cut_at_its_sides() {
        assert_eq!(line(&[(-1.0, 0.5), (2.0, 0.5)]), [[(0.0, 0.5), (1.0, 0.5)]]);
    }

    #[test]
    fn a_line_that_leaves_and_comes_back_is_two() {
        let parts = line(&[(0.25, 0.5), (0.5, 1.5), (0.75, 0.5)]);
        assert_eq!(
            parts,
            [[(0.25, 0.5), (0.375, 1.0)], [(0.625, 1.0), (0.75, 0.5)]]
        );
    }

    #[test]
    fn a_line_that_passes_by_is_nothing() {
        assert!(line(&[(-1.0, 0.5), (0.5, 3.0)]).is_empty());
    }

    #[test]
    fn an_area_around_the_square_is_the_square() {
        let mut square = area(&[(-1.0, -1.0), (2.0, -1.0), (2.0, 2.0), (-1.0, 2.0)]);
        square.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
        assert_eq!(square, [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]);
    }
}
