//! Guides: lines across a panel that are not data, and the places of their names.
//!
//! A name is written beside its line where it touches no data, no other guide and no other name. If
//! there is no such place, it goes into the legend.

use crate::chart::{Guide, GuideAt};
use crate::clip;
use crate::layout::{Frame, GUIDE_SIZE};
use crate::look::Looks;
use crate::scene::{Layer, Place, Shape, Text};
use crate::span::Span;
use crate::text;

/// Gap between a name and its line.
const CLEAR: f64 = 2.0;

/// Gap between a name and the box.
const INDENT: f64 = 4.0;

/// A line is tested for crossing a name at points that are at most this far apart.
const STRIDE: f64 = 2.0;

/// Two places closer than this, in lengths of a panel's side, do not define a direction.
const SAME: f64 = 1e-6;

/// A name that found a place on the page.
#[derive(Debug, Clone)]
pub(crate) struct Label {
    name: String,
    room: Frame,
}

impl Label {
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The text of the name; opaque over a map.
    pub(crate) fn shape(&self, is_over_map: bool) -> Shape {
        let base = self.room.bottom() - GUIDE_SIZE * 0.28;
        let text = Text::at((self.room.left, base), GUIDE_SIZE, &self.name);
        Shape::Text(text.rim().opacity(if is_over_map { 100 } else { 80 }))
    }
}

/// The visible part of a guide, in the unit square.
fn line(at: GuideAt, x: &Span, y: &Span) -> Option<Vec<Place>> {
    let ends = match at {
        GuideAt::Y(level) => {
            let level = y.fraction(level)?;
            [(0.0, level), (1.0, level)]
        }
        GuideAt::X(across) => {
            let across = x.fraction(across)?;
            [(across, 0.0), (across, 1.0)]
        }
        GuideAt::Line(a, b) => {
            let from = (x.fraction(a.0)?, y.fraction(a.1)?);
            let to = (x.fraction(b.0)?, y.fraction(b.1)?);
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let length = dx.hypot(dy);
            if length < SAME {
                return None;
            }
            // Far enough to leave the panel on both sides, wherever the two points are.
            let reach = (from.0.hypot(from.1) + 2.0) / length;
            [
                (from.0 - reach * dx, from.1 - reach * dy),
                (from.0 + reach * dx, from.1 + reach * dy),
            ]
        }
    };
    clip::line(&ends).into_iter().next()
}

/// The visible lines of the guides.
pub(crate) fn layer(guides: &[Guide], looks: &Looks, frame: &Frame, x: &Span, y: &Span) -> Layer {
    let shapes = guides
        .iter()
        .filter_map(|guide| {
            Some(Shape::Lines {
                lines: vec![frame.places(&line(guide.at, x, y)?)],
                stroke: looks.guide(guide).stroke(0.7),
            })
        })
        .collect();
    Layer { name: None, shapes }
}

/// The names that find a place beside the data, and the guides whose names do not.
pub(crate) fn labels<'a>(
    guides: &'a [Guide],
    data: &[Layer],
    frame: &Frame,
    x: &Span,
    y: &Span,
) -> (Vec<Label>, Vec<&'a Guide>) {
    let seen: Vec<(&Guide, Vec<Place>)> = guides
        .iter()
        .filter_map(|guide| Some((guide, frame.places(&line(guide.at, x, y)?))))
        .collect();
    let mut labels: Vec<Label> = Vec::new();
    let mut beside = Vec::new();
    for (guide, own) in seen.iter().filter(|(guide, _)| !guide.name.is_empty()) {
        // The two ends of a range share a name, which is written once.
        if labels.iter().any(|label| label.name == guide.name) {
            continue;
        }
        let free = |room: &Frame| {
            let mut others = seen.iter().filter(|(other, _)| other.name != guide.name);
            frame.contains((room.left, room.top))
                && frame.contains((room.right(), room.bottom()))
                && labels.iter().all(|label| !label.room.overlaps(room))
                && others.all(|(_, line)| !crosses(line, room))
                && data
                    .iter()
                    .flat_map(|layer| &layer.shapes)
                    .all(|shape| !touches(shape, room))
        };
        let place = candidates(&guide.name, own, frame).into_iter().find(free);
        match place {
            Some(room) => labels.push(Label {
                name: guide.name.clone(),
                room,
            }),
            None => beside.push(*guide),
        }
    }
    (labels, beside)
}

/// Possible places of a name beside its line, the best first.
fn candidates(name: &str, line: &[Place], frame: &Frame) -> Vec<Frame> {
    let (width, height) = (text::width(name, GUIDE_SIZE, false), GUIDE_SIZE * 1.1);
    let room = |left: f64, top: f64| Frame {
        left,
        top,
        width,
        height,
    };
    let [from, to] = line else {
        return Vec::new();
    };
    if from.0 == to.0 {
        let rows = [frame.top + INDENT, frame.bottom() - INDENT - height];
        return rows
            .iter()
            .flat_map(|top| {
                [
                    room(from.0 + CLEAR, *top),
                    room(from.0 - CLEAR - width, *top),
                ]
            })
            .collect();
    }
    let level = |x: f64| from.1 + (x - from.0) / (to.0 - from.0) * (to.1 - from.1);
    let (least, most) = (from.0.min(to.0), from.0.max(to.0));
    [0.0, 1.0, 0.5, 0.25, 0.75]
        .iter()
        .flat_map(|back| {
            let left = most - INDENT - width - back * (most - least - width - 2.0 * INDENT);
            let (a, b) = (level(left), level(left + width));
            [
                room(left, a.min(b) - CLEAR * 0.5 - height),
                room(left, a.max(b) + CLEAR * 0.5),
            ]
        })
        .collect()
}

/// Whether a line passes through a rectangle.
fn crosses(line: &[Place], room: &Frame) -> bool {
    let near = Frame {
        left: room.left - 1.0,
        top: room.top,
        width: room.width + 2.0,
        height: room.height,
    };
    line.iter().zip(line.iter().skip(1)).any(|(from, to)| {
        let apart = from.0.max(to.0) < near.left
            || from.0.min(to.0) > near.right()
            || from.1.max(to.1) < near.top
            || from.1.min(to.1) > near.bottom();
        if apart {
            return false;
        }
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let stretches = (dx.hypot(dy) / STRIDE).ceil().max(1.0);
        (0..=stretches as u32).any(|n| {
            let t = f64::from(n) / stretches;
            near.contains((from.0 + t * dx, from.1 + t * dy))
        })
    })
}

fn touches(shape: &Shape, room: &Frame) -> bool {
    match shape {
        Shape::Lines { lines, .. } => lines.iter().any(|line| crosses(line, room)),
        Shape::Markers { places, size, .. } => {
            let near = Frame {
                left: room.left - size / 2.0,
                top: room.top - size / 2.0,
                width: room.width + size,
                height: room.height + size,
            };
            places.iter().any(|place| near.contains(*place))
        }
        Shape::Areas { areas, .. } => areas.iter().any(|area| {
            let middle = (room.left + room.width / 2.0, room.top + room.height / 2.0);
            crosses(area, room) || encloses(area, middle)
        }),
        Shape::Text(_) => false,
    }
}

/// Whether a place is inside an area: a ray from it crosses the outline an odd number of times.
fn encloses(area: &[Place], place: Place) -> bool {
    area.iter()
        .zip(area.iter().cycle().skip(1))
        .filter(|(a, b)| {
            (a.1 > place.1) != (b.1 > place.1)
                && place.0 < a.0 + (place.1 - a.1) / (b.1 - a.1) * (b.0 - a.0)
        })
        .count()
        % 2
        == 1
}
