//! Marks at the edge of a panel for values beyond its range, with their numbers: a dot or a bar that leaves
//! the panel would otherwise not be seen, or be taken for a smaller one.

use crate::axis::Scale;
use crate::layout::{Frame, GUIDE_SIZE};
use crate::palette::Colour;
use crate::point::Point;
use crate::scene::{Layer, Marker, Shape, Text};
use crate::text;
use crate::tick;

/// Marks of a series are at least this far apart; of closer values the farthest has one.
const APART: f64 = 10.0;

/// Width of a mark.
const SIZE: f64 = 4.5;

/// Gap between a mark and the edge, from which it points away.
const EDGE: f64 = 1.5;

/// Gap between a mark and its number.
const BESIDE: f64 = 1.5;

/// Of the points beyond a panel of this width, the farthest of each place that has room for a mark. On a
/// logarithmic axis what is below the range is close to nothing, and has none.
pub(crate) fn farthest(points: &[Point], width: f64, scale: Scale) -> Vec<Point> {
    let is_beyond = |point: &&Point| {
        let is_below = point.at.1 < 0.0 && scale == Scale::Linear;
        (0.0..=1.0).contains(&point.at.0) && (is_below || point.at.1 > 1.0)
    };
    let mut kept: Vec<Point> = Vec::new();
    for point in points.iter().filter(is_beyond) {
        let place = |point: &Point| ((point.at.0 * width / APART).floor(), point.at.1 > 0.5);
        let distance = |point: &Point| (point.at.1 - 0.5).abs();
        match kept.iter_mut().find(|other| place(other) == place(point)) {
            Some(other) if distance(other) < distance(point) => *other = *point,
            Some(_) => {}
            None => kept.push(*point),
        }
    }
    kept
}

/// The marks of all series of a panel, and the numbers that find room.
pub(crate) fn layer(series: &[(Colour, &[Point])], frame: &Frame, scale: Scale) -> Layer {
    let mut shapes = Vec::new();
    let mut numbers: Vec<(Frame, Text)> = Vec::new();
    for (colour, points) in series {
        for point in farthest(points, frame.width, scale) {
            let is_above = point.at.1 > 0.5;
            let x = frame.place(point.at).0;
            // The corners of a triangle reach 1.1 of its half width.
            let reach = SIZE * 0.55;
            let x = x.clamp(frame.left + reach, frame.right() - reach);
            let (y, shape) = if is_above {
                (frame.top + reach + EDGE, Marker::Triangle)
            } else {
                (frame.bottom() - reach - EDGE, Marker::Down)
            };
            shapes.push(Shape::Markers {
                places: vec![(x, y)],
                shape,
                size: SIZE,
                colour: *colour,
                opacity: 100,
            });
            let content = tick::short(point.value.1);
            let width = text::width(&content, GUIDE_SIZE, false);
            let right = x + reach + BESIDE;
            let left = x - reach - BESIDE - width;
            let free = [right, left].into_iter().find_map(|left| {
                let room = Frame {
                    left,
                    top: y - GUIDE_SIZE / 2.0,
                    width,
                    height: GUIDE_SIZE,
                };
                let is_free = left >= frame.left
                    && room.right() <= frame.right()
                    && numbers.iter().all(|(other, _)| !other.overlaps(&room));
                is_free.then_some(room)
            });
            if let Some(room) = free {
                let at = (room.left, y + GUIDE_SIZE * 0.34);
                numbers.push((room, Text::at(at, GUIDE_SIZE, content).rim()));
            }
        }
    }
    shapes.extend(numbers.into_iter().map(|(_, text)| Shape::Text(text)));
    // A mark may lie on a bar of its colour.
    Layer { name: None, shapes }.rimmed()
}
