//! A chart as PDF: its scene as one page of vector graphics.
//!
//! The characters that it uses are embedded ([`crate::font`]). The file has no date and no random id,
//! and nothing is compressed, so that the same chart gives the same bytes. What is around the page is
//! in `document`.

use std::collections::BTreeSet;

use pdf_writer::types::{LineCapStyle, LineJoinStyle, TextRenderingMode};
use pdf_writer::{Content, Name, Str};

use crate::document::{Page, document, number, opacity_name};
use crate::drawing::Drawing;
use crate::font::Font;
use crate::palette::Colour;
use crate::scene::{Anchor, Marker, Percent, Place, Shape, Stroke, Text};
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
        let mut page = Page {
            width: scene.width,
            height: scene.height,
            content: Content::new(),
            opacities: BTreeSet::new(),
            regular: Font::regular(),
            bold: Font::bold(),
        };
        page.fill(Colour::Paper, 100);
        let (width, height) = (number(scene.width), number(scene.height));
        page.content.rect(0.0, 0.0, width, height).fill_nonzero();
        page.content.set_line_join(LineJoinStyle::RoundJoin);
        for shape in scene.layers.iter().flat_map(|layer| &layer.shapes) {
            page.shape(shape);
        }
        document(self.chart, page)
    }
}

impl Page {
    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Lines { lines, stroke } => {
                self.stroke(stroke);
                for line in lines {
                    self.path(line);
                }
                self.content.stroke();
            }
            Shape::Areas {
                areas,
                colour,
                opacity,
            } => {
                self.fill(*colour, *opacity);
                for area in areas {
                    self.path(area);
                    self.content.close_path();
                }
                self.content.fill_nonzero();
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

    fn place(&self, (x, y): Place) -> (f32, f32) {
        (number(x), number(self.height - y))
    }

    fn path(&mut self, line: &[Place]) {
        for (index, place) in line.iter().enumerate() {
            let (x, y) = self.place(*place);
            if index == 0 {
                self.content.move_to(x, y);
            } else {
                self.content.line_to(x, y);
            }
        }
    }

    fn opacity(&mut self, covered: Percent) {
        self.opacities.insert(covered);
        let name = opacity_name(covered);
        self.content.set_parameters(Name(name.as_bytes()));
    }

    fn fill(&mut self, colour: Colour, covered: Percent) {
        self.opacity(covered);
        let [red, green, blue] = shares(colour);
        self.content.set_fill_rgb(red, green, blue);
    }

    fn stroke(&mut self, stroke: &Stroke) {
        self.opacity(stroke.opacity);
        let [red, green, blue] = shares(stroke.colour);
        let cap = if stroke.dash.is_empty() {
            LineCapStyle::RoundCap
        } else {
            LineCapStyle::ButtCap
        };
        self.content
            .set_stroke_rgb(red, green, blue)
            .set_line_width(number(stroke.width).max(0.0))
            .set_line_cap(cap)
            .set_dash_pattern(stroke.dash.iter().copied().map(number), 0.0);
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
                let (x, y) = self.place(*place);
                self.content.move_to(x, y).line_to(x, y);
            }
            self.content.stroke();
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
            self.content.close_path();
        }
        self.content.fill_nonzero();
    }

    fn circle(&mut self, middle: Place, radius: f64) {
        self.path(&[(middle.0 + radius, middle.1)]);
        let q = QUARTER;
        for quarter in [
            [(1.0, q), (q, 1.0), (0.0, 1.0)],
            [(-q, 1.0), (-1.0, q), (-1.0, 0.0)],
            [(-1.0, -q), (-q, -1.0), (0.0, -1.0)],
            [(q, -1.0), (1.0, -q), (1.0, 0.0)],
        ] {
            let [a, b, end] = quarter
                .map(|(dx, dy)| self.place((middle.0 + dx * radius, middle.1 + dy * radius)));
            self.content.cubic_to(a.0, a.1, b.0, b.1, end.0, end.1);
        }
    }

    fn text(&mut self, text: &Text) {
        if text.rim {
            self.stroke(&Stroke::solid(Colour::Paper, 2.0));
            self.written(text, TextRenderingMode::Stroke);
        }
        self.fill(text.colour, text.opacity);
        self.written(text, TextRenderingMode::Fill);
    }

    /// Writes a text, run by run.
    fn written(&mut self, text: &Text, mode: TextRenderingMode) {
        let width = text::width(&text.content, text.size, text.bold);
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => width / 2.0,
            Anchor::End => width,
        };
        let (x, y) = text.at;
        let matrix = if text.upright {
            let (x, y) = self.place((x, y + back));
            [0.0, 1.0, -1.0, 0.0, x, y]
        } else {
            let (x, y) = self.place((x - back, y));
            [1.0, 0.0, 0.0, 1.0, x, y]
        };
        let font = if text.bold {
            &mut self.bold
        } else {
            &mut self.regular
        };
        self.content
            .begin_text()
            .set_text_rendering_mode(mode)
            .set_text_matrix(matrix);
        for run in text::runs(&text.content) {
            let (size, rise) = if run.raised {
                (text.size * RAISED_SIZE, text.size * RAISED_BY)
            } else {
                (text.size, 0.0)
            };
            let glyphs: Vec<u8> = run
                .content
                .chars()
                .flat_map(|c| font.glyph(c).to_be_bytes())
                .collect();
            self.content
                .set_font(font.name_on_page, number(size))
                .set_rise(number(rise))
                .show(Str(&glyphs));
        }
        self.content.end_text();
    }
}

/// The shares of red, green and blue, to a thousandth.
fn shares(colour: Colour) -> [f32; 3] {
    colour
        .rgb()
        .map(|part| (f32::from(part) / 0.255).round() / 1e3)
}
