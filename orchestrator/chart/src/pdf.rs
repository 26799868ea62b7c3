//! A chart as PDF: its scene as one page of vector graphics.
//!
//! The characters that it uses are embedded ([`crate::font`]). The file has no date and no random id,
//! and nothing is compressed, so that the same chart gives the same bytes. What is around the page is
//! in `document`.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::document::{Content, document};
use crate::drawing::Drawing;
use crate::font::Font;
use crate::palette::Colour;
use crate::scene::{Anchor, Marker, Percent, Place, Shape, Stroke, Text};
use crate::svg::number;
use crate::text::{self, RAISED_BY, RAISED_SIZE};

/// Distance of a control point from its end of a quarter circle, in radii.
const QUARTER: f64 = 0.552_284_75;

impl Drawing<'_> {
    /// The chart as a PDF document of one page, as large as the drawing.
    ///
    /// The same chart gives the same bytes.
    #[must_use]
    pub fn to_pdf(&self) -> Vec<u8> {
        let scene = &self.scene;
        let mut content = Content {
            height: scene.height,
            operators: String::new(),
            opacities: BTreeSet::new(),
            regular: Font::regular(),
            bold: Font::bold(),
        };
        content.fill(Colour::Paper, 100);
        content.path(&[
            (0.0, 0.0),
            (scene.width, 0.0),
            (scene.width, scene.height),
            (0.0, scene.height),
        ]);
        content.operators.push_str("h f\n1 j\n");
        for shape in scene.layers.iter().flat_map(|layer| &layer.shapes) {
            content.shape(shape);
        }
        document(self.chart, (scene.width, scene.height), &content)
    }
}

/// Writing to a [`String`] cannot fail.
macro_rules! put {
    ($text:expr, $($what:tt)*) => {
        write!($text, $($what)*).unwrap_or_default()
    };
}

impl Content {
    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Lines { lines, stroke } => {
                self.stroke(stroke);
                for line in lines {
                    self.path(line);
                }
                self.operators.push_str("S\n");
            }
            Shape::Areas {
                areas,
                colour,
                opacity,
            } => {
                self.fill(*colour, *opacity);
                for area in areas {
                    self.path(area);
                    self.operators.push_str("h ");
                }
                self.operators.push_str("f\n");
            }
            Shape::Markers {
                places,
                shape,
                size,
                colour,
                opacity,
            } => self.markers(places, *shape, *size, *colour, *opacity),
            Shape::Text(text) => self.text(text),
        }
    }

    fn place(&self, place: Place) -> String {
        format!("{} {}", number(place.0), number(self.height - place.1))
    }

    fn path(&mut self, line: &[Place]) {
        for (index, place) in line.iter().enumerate() {
            let place = self.place(*place);
            put!(
                self.operators,
                "{place} {} ",
                if index == 0 { "m" } else { "l" }
            );
        }
    }

    fn opacity(&mut self, covered: Percent) {
        self.opacities.insert(covered);
        put!(self.operators, "/O{covered} gs ");
    }

    fn fill(&mut self, colour: Colour, covered: Percent) {
        self.opacity(covered);
        put!(self.operators, "{} rg ", rgb(colour));
    }

    fn stroke(&mut self, stroke: &Stroke) {
        self.opacity(stroke.opacity);
        let lengths: Vec<String> = stroke.dash.iter().map(|length| number(*length)).collect();
        let cap = i32::from(stroke.dash.is_empty());
        put!(
            self.operators,
            "{} RG {} w {cap} J [{}] 0 d ",
            rgb(stroke.colour),
            number(stroke.width),
            lengths.join(" ")
        );
    }

    fn markers(
        &mut self,
        places: &[Place],
        shape: Marker,
        size: f64,
        colour: Colour,
        covered: Percent,
    ) {
        if shape == Marker::Disc && places.len() > 60 {
            // A line of zero length with round ends is a disc, and takes the least room in the file.
            self.stroke(&Stroke {
                opacity: covered,
                ..Stroke::solid(colour, size)
            });
            for place in places {
                let place = self.place(*place);
                put!(self.operators, "{place} m {place} l ");
            }
            self.operators.push_str("S\n");
            return;
        }
        self.fill(colour, covered);
        let radius = size / 2.0;
        for (x, y) in places {
            if shape == Marker::Disc {
                self.circle((*x, *y), radius);
            } else {
                let corners = shape.corners().iter();
                let corners: Vec<Place> = corners
                    .map(|corner| (x + corner.0 * radius, y + corner.1 * radius))
                    .collect();
                self.path(&corners);
            }
            self.operators.push_str("h ");
        }
        self.operators.push_str("f\n");
    }

    fn circle(&mut self, middle: Place, radius: f64) {
        let at = |dx: f64, dy: f64| self.place((middle.0 + dx * radius, middle.1 + dy * radius));
        let q = QUARTER;
        let mut circle = format!("{} m ", at(1.0, 0.0));
        for [a, b, end] in [
            [(1.0, q), (q, 1.0), (0.0, 1.0)],
            [(-q, 1.0), (-1.0, q), (-1.0, 0.0)],
            [(-1.0, -q), (-q, -1.0), (0.0, -1.0)],
            [(q, -1.0), (1.0, -q), (1.0, 0.0)],
        ] {
            put!(
                circle,
                "{} {} {} c ",
                at(a.0, a.1),
                at(b.0, b.1),
                at(end.0, end.1)
            );
        }
        self.operators.push_str(&circle);
    }

    fn text(&mut self, text: &Text) {
        let width = text::width(&text.content, text.size, text.bold);
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => width / 2.0,
            Anchor::End => width,
        };
        let (x, y) = text.at;
        let matrix = if text.upright {
            format!("0 1 -1 0 {}", self.place((x, y + back)))
        } else {
            format!("1 0 0 1 {}", self.place((x - back, y)))
        };
        let written = self.written(text);
        if text.rim {
            self.stroke(&Stroke::solid(Colour::Paper, 2.0));
            put!(self.operators, "BT 1 Tr {matrix} Tm {written}ET\n");
        }
        self.fill(text.colour, text.opacity);
        put!(self.operators, "BT 0 Tr {matrix} Tm {written}ET\n");
    }

    /// The operators that write a text, run by run.
    fn written(&mut self, text: &Text) -> String {
        let (font, name) = if text.bold {
            (&mut self.bold, "B")
        } else {
            (&mut self.regular, "F")
        };
        let mut operators = String::new();
        for run in text::runs(&text.content) {
            let (size, rise) = if run.raised {
                (text.size * RAISED_SIZE, text.size * RAISED_BY)
            } else {
                (text.size, 0.0)
            };
            let glyphs: String = run
                .content
                .chars()
                .map(|c| format!("{:04X}", font.glyph(c)))
                .collect();
            let (size, rise) = (number(size), number(rise));
            put!(operators, "/{name} {size} Tf {rise} Ts <{glyphs}> Tj ");
        }
        operators
    }
}

fn rgb(colour: Colour) -> String {
    let shares = colour
        .rgb()
        .map(|part| format!("{:.3}", f64::from(part) / 255.0));
    shares.join(" ")
}
