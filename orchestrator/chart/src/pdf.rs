//! A chart as PDF: its scene as one page of vectors.
//!
//! Text is set in Helvetica and Symbol, two of the fourteen fonts that PDF readers have to bring
//! (ISO 32000-1, 9.6.2.2), so no font file is needed to write or to read it. What these fonts do
//! not have is written as `?`. There is no date and no random id in the file, and nothing is
//! compressed, so that the same chart is the same bytes.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::chart::Chart;
use crate::encoding::code;
use crate::page;
use crate::palette::Colour;
use crate::scene::{Anchor, Marker, Percent, Place, Scene, Shape, Stroke, Text};
use crate::svg::number;
use crate::text::{self, RAISED_BY, RAISED_SIZE};

/// How far a control point is from the end of a quarter of a circle, in radii.
const QUARTER: f64 = 0.552_284_75;

impl Chart {
    /// The chart as a PDF document of one page, as large as the drawing.
    ///
    /// The same chart gives the same bytes.
    #[must_use]
    pub fn to_pdf(&self) -> Vec<u8> {
        let scene = page::scene(self);
        let mut content = Content {
            height: scene.height,
            operators: String::new(),
            opacities: BTreeSet::new(),
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
        document(self, &scene, &content)
    }
}

/// Writing to a [`String`] cannot fail.
macro_rules! put {
    ($text:expr, $($what:tt)*) => {
        write!($text, $($what)*).unwrap_or_default()
    };
}

/// The objects of the document, their places in the file, and what readers start from.
fn document(chart: &Chart, scene: &Scene, content: &Content) -> Vec<u8> {
    let states: String = content
        .opacities
        .iter()
        .map(|covered| {
            let alpha = number(f64::from(*covered) / 100.0);
            format!("/O{covered} << /ca {alpha} /CA {alpha} >> ")
        })
        .collect();
    let font = |name: &str, encoding: &str| {
        format!("<< /Type /Font /Subtype /Type1 /BaseFont /{name}{encoding} >>")
    };
    let latin = " /Encoding /WinAnsiEncoding";
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R /Lang (en-GB) /ViewerPreferences << /DisplayDocTitle true >> >>"
            .to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R /Resources << \
             /Font << /F 5 0 R /B 6 0 R /S 7 0 R >> /ExtGState << {states}>> >> >>",
            number(scene.width),
            number(scene.height)
        ),
        format!(
            "<< /Length {} >>\nstream\n{}\nendstream",
            content.operators.len(),
            content.operators
        ),
        font("Helvetica", latin),
        font("Helvetica-Bold", latin),
        font("Symbol", ""),
        format!(
            "<< /Title {} /Subject {} /Producer (webloop) >>",
            title(&chart.title),
            title(&chart.about)
        ),
    ];
    let mut file = String::from("%PDF-1.7\n");
    let mut places = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        places.push(file.len());
        put!(file, "{} 0 obj\n{object}\nendobj\n", index + 1);
    }
    let table = file.len();
    put!(file, "xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for place in &places {
        put!(file, "{place:010} 00000 n \n");
    }
    put!(
        file,
        "trailer\n<< /Size {} /Root 1 0 R /Info 8 0 R >>\nstartxref\n{table}\n%%EOF\n",
        objects.len() + 1
    );
    file.into_bytes()
}

/// Any text, as the UTF-16 that PDF's titles are in.
fn title(text: &str) -> String {
    let units: String = text
        .encode_utf16()
        .map(|unit| format!("{unit:04X}"))
        .collect();
    format!("<FEFF{units}>")
}

/// The operators that draw a page.
struct Content {
    /// Of the page: PDF counts upwards from the bottom.
    height: f64,
    operators: String,
    /// Those that are used.
    opacities: BTreeSet<Percent>,
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
            // A line of no length with round ends is a disc, and takes the least room in the file.
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
        let written = written(text);
        if text.rim {
            self.stroke(&Stroke::solid(Colour::Paper, 2.0));
            put!(self.operators, "BT 1 Tr {matrix} Tm {written}ET\n");
        }
        self.fill(Colour::Ink, text.opacity);
        put!(self.operators, "BT 0 Tr {matrix} Tm {written}ET\n");
    }
}

fn rgb(colour: Colour) -> String {
    let shares = colour
        .rgb()
        .map(|part| format!("{:.3}", f64::from(part) / 255.0));
    shares.join(" ")
}

/// The operators that write a text, in stretches of one font and one level.
fn written(text: &Text) -> String {
    let mut operators = String::new();
    let plain = if text.bold { "B" } else { "F" };
    for run in text::runs(&text.content) {
        let (size, rise) = if run.raised {
            (text.size * RAISED_SIZE, text.size * RAISED_BY)
        } else {
            (text.size, 0.0)
        };
        let codes: Vec<(&str, u8)> = run.content.chars().map(|c| code(c, plain)).collect();
        for stretch in codes.chunk_by(|a, b| a.0 == b.0) {
            let font = stretch.first().map_or(plain, |(font, _)| *font);
            let bytes: String = stretch
                .iter()
                .map(|(_, code)| format!("{code:02X}"))
                .collect();
            let (size, rise) = (number(size), number(rise));
            put!(operators, "/{font} {size} Tf {rise} Ts <{bytes}> Tj ");
        }
    }
    operators
}
