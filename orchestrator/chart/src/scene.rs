//! A drawing as a list of shapes: all that the writers of SVG and PDF need to know.
//!
//! Lengths are in points (1/72 inch), from the top left corner, y downwards.

use crate::palette::Colour;

/// A place on the page: x, y.
pub(crate) type Place = (f64, f64);

/// A whole drawing.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// Layers, the lowest first.
    pub(crate) layers: Vec<Layer>,
}

/// Shapes that belong together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layer {
    /// The name of what they show, if it has one.
    pub(crate) name: Option<String>,
    pub(crate) shapes: Vec<Shape>,
}

/// Width of a rim on each side.
const RIM: f64 = 0.7;

impl Layer {
    /// Adds a rim in the colour of the paper to lines and markers, so that they are visible over tiles.
    pub(crate) fn rimmed(self) -> Layer {
        let rims = self.shapes.iter().filter_map(|shape| match shape {
            Shape::Lines { lines, stroke } => Some(Shape::Lines {
                lines: lines.clone(),
                stroke: Stroke::solid(Colour::Paper, stroke.width + 2.0 * RIM),
            }),
            Shape::Markers {
                places,
                shape,
                size,
                ..
            } => Some(Shape::Markers {
                places: places.clone(),
                shape: *shape,
                size: size + 2.0 * RIM,
                colour: Colour::Paper,
                opacity: 100,
            }),
            Shape::Areas { .. } | Shape::Text(_) => None,
        });
        Layer {
            shapes: rims
                .collect::<Vec<_>>()
                .into_iter()
                .chain(self.shapes)
                .collect(),
            name: self.name,
        }
    }
}

/// A shape that can be drawn.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// Open lines, all with the same stroke.
    Lines {
        lines: Vec<Vec<Place>>,
        stroke: Stroke,
    },
    /// Closed areas, all with the same fill.
    Areas {
        areas: Vec<Vec<Place>>,
        colour: Colour,
        opacity: Percent,
    },
    /// The same small shape at many places.
    Markers {
        places: Vec<Place>,
        shape: Marker,
        /// Width of the shape, in points.
        size: f64,
        colour: Colour,
        opacity: Percent,
    },
    /// One line of text.
    Text(Text),
}

/// Opacity, from 0 to 100.
pub(crate) type Percent = u8;

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
    /// Lengths of stroke and gap in turn; empty for a solid line.
    pub(crate) dash: &'static [f64],
    pub(crate) opacity: Percent,
}

impl Stroke {
    /// A solid line.
    pub(crate) fn solid(colour: Colour, width: f64) -> Self {
        Stroke {
            colour,
            width,
            dash: &[],
            opacity: 100,
        }
    }
}

/// A small shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Disc,
    Square,
    Triangle,
    /// A triangle that points down.
    Down,
    Diamond,
}

impl Marker {
    /// Its corners about (0, 0) for a width of 2; none for a disc.
    pub(crate) fn corners(self) -> &'static [Place] {
        match self {
            Marker::Disc => &[],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.1), (1.1, 0.9), (-1.1, 0.9)],
            Marker::Down => &[(0.0, 1.1), (1.1, -0.9), (-1.1, -0.9)],
            Marker::Diamond => &[(0.0, -1.2), (1.2, 0.0), (0.0, 1.2), (-1.2, 0.0)],
        }
    }
}

/// One line of text.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    /// The place of its anchor on the baseline.
    pub(crate) at: Place,
    pub(crate) content: String,
    /// Font size, in points.
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) bold: bool,
    /// Whether it is rotated to read upwards.
    pub(crate) upright: bool,
    pub(crate) colour: Colour,
    /// Whether it has a rim in the colour of the paper, so that it can be read over lines.
    pub(crate) rim: bool,
    pub(crate) opacity: Percent,
}

impl Text {
    /// Plain text that starts here.
    pub(crate) fn at(at: Place, size: f64, content: impl Into<String>) -> Self {
        Text {
            at,
            content: content.into(),
            size,
            anchor: Anchor::Start,
            bold: false,
            upright: false,
            colour: Colour::Ink,
            rim: false,
            opacity: 100,
        }
    }

    pub(crate) fn anchor(self, anchor: Anchor) -> Self {
        Text { anchor, ..self }
    }

    pub(crate) fn bold(self) -> Self {
        Text { bold: true, ..self }
    }

    pub(crate) fn upright(self) -> Self {
        Text {
            upright: true,
            ..self
        }
    }

    pub(crate) fn colour(self, colour: Colour) -> Self {
        Text { colour, ..self }
    }

    pub(crate) fn rim(self) -> Self {
        Text { rim: true, ..self }
    }

    pub(crate) fn opacity(self, opacity: Percent) -> Self {
        Text { opacity, ..self }
    }
}

/// The part of a text that is at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}
