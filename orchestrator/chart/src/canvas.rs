//! A picture of pixels, on which the shapes of a scene are painted one over the other.

use zeno::{Cap, Command, Join, Mask, Scratch, Style, Vector};

use crate::face::Face;
use crate::font::{BOLD, REGULAR};
use crate::outline::Point;
use crate::palette::Colour;
use crate::scene::{Anchor, Marker, Percent, Place, Scene, Shape, Stroke, Text};
use crate::text::{self, RAISED_BY, RAISED_SIZE};

/// Pixels per point: 192 to the inch, twice a screen's 96.
pub(crate) const SCALE: f64 = 8.0 / 3.0;

/// Distance of a control point from its end of a quarter circle, in radii.
const QUARTER: f64 = 0.552_284_75;

/// How far outside of the picture a shape may reach, in pixels. The rasteriser casts coordinates to whole
/// numbers unchecked, so none may be endless or no number.
const BEYOND: f64 = 64.0;

/// The picture: rows from the top, each pixel red, green and blue.
pub(crate) struct Canvas {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<[u8; 3]>,
    regular: Face,
    bold: Face,
    scratch: Scratch,
}

impl Canvas {
    /// The picture of a scene.
    pub(crate) fn paint(scene: &Scene) -> Canvas {
        let pixels = |points: f64| (points * SCALE).ceil() as usize;
        let (width, height) = (pixels(scene.width), pixels(scene.height));
        let face = |data| Face::parse(data).expect("a font in this crate, which tests parse");
        let mut canvas = Canvas {
            width,
            height,
            pixels: vec![Colour::Paper.rgb(); width * height],
            regular: face(REGULAR),
            bold: face(BOLD),
            scratch: Scratch::new(),
        };
        for shape in scene.layers.iter().flat_map(|layer| &layer.shapes) {
            canvas.shape(shape);
        }
        canvas
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Lines { lines, stroke } => {
                let mut path = self.path();
                for line in lines {
                    path.line(line);
                }
                let path = path.commands;
                self.stroke(&path, stroke);
            }
            Shape::Areas {
                areas,
                colour,
                opacity,
            } => {
                let mut path = self.path();
                for area in areas {
                    path.line(area);
                    path.commands.push(Command::Close);
                }
                let path = path.commands;
                self.fill(&path, *colour, *opacity);
            }
            Shape::Markers {
                places,
                shape,
                size,
                colour,
                opacity,
            } => {
                let mut path = self.path();
                for place in places {
                    path.marker(*place, *shape, size / 2.0);
                }
                let path = path.commands;
                self.fill(&path, *colour, *opacity);
            }
            Shape::Text(text) => {
                let path = self.written(text);
                if text.rim {
                    self.stroke(&path, &Stroke::solid(Colour::Paper, 2.0));
                }
                self.fill(&path, text.colour, text.opacity);
            }
        }
    }

    fn path(&self) -> Path {
        Path {
            commands: Vec::new(),
            width: self.width as f64,
            height: self.height as f64,
        }
    }

    /// The outlines of a line of text.
    fn written(&self, text: &Text) -> Vec<Command> {
        let face = if text.bold { &self.bold } else { &self.regular };
        let width = text::width(&text.content, text.size, text.bold);
        let mut along = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        };
        let mut path = self.path();
        for run in text::runs(&text.content) {
            let (size, rise) = if run.raised {
                (text.size * RAISED_SIZE, text.size * RAISED_BY)
            } else {
                (text.size, 0.0)
            };
            let em = size / f64::from(face.units_per_em());
            for (glyph, _) in run.content.chars().map(|c| face.nearest(c)) {
                let place = |x: f64, y: f64| {
                    let (x, y) = (along + x * em, rise + y * em);
                    if text.upright {
                        (text.at.0 - y, text.at.1 - x)
                    } else {
                        (text.at.0 + x, text.at.1 - y)
                    }
                };
                for contour in face.contours(glyph) {
                    path.contour(&contour, &place);
                }
                along += f64::from(face.advance(glyph)) * em;
            }
        }
        path.commands
    }

    fn fill(&mut self, path: &[Command], colour: Colour, covered: Percent) {
        self.put(path, Style::default(), colour, covered);
    }

    fn stroke(&mut self, path: &[Command], stroke: &Stroke) {
        let pixels = |points: f64| (points * SCALE) as f32;
        let dashes: Vec<f32> = stroke.dash.iter().copied().map(pixels).collect();
        let mut style = zeno::Stroke::new(pixels(stroke.width));
        style.join(Join::Round).dash(&dashes, 0.0);
        style.cap(if dashes.is_empty() {
            Cap::Round
        } else {
            Cap::Butt
        });
        self.put(path, Style::Stroke(style), stroke.colour, stroke.opacity);
    }

    /// Paints what a path covers, in part where it covers a pixel in part.
    fn put(&mut self, path: &[Command], style: Style<'_>, colour: Colour, covered: Percent) {
        let (mask, at) = Mask::with_scratch(path, &mut self.scratch)
            .style(style)
            .render();
        let colour = colour.rgb();
        let rows = mask.chunks_exact((at.width as usize).max(1));
        let skipped = usize::try_from(-at.left).unwrap_or(0);
        let first = usize::try_from(at.left).unwrap_or(0).min(self.width);
        for (row, y) in rows.zip(at.top..) {
            let Some(y) = usize::try_from(y).ok().filter(|y| *y < self.height) else {
                continue;
            };
            let pixels = &mut self.pixels[y * self.width..][first..self.width];
            let parts = row.get(skipped..).unwrap_or_default();
            for (pixel, part) in pixels.iter_mut().zip(parts) {
                if *part > 0 {
                    let part = u32::from(*part) * u32::from(covered);
                    *pixel = [0, 1, 2].map(|i| mixed(pixel[i], colour[i], part));
                }
            }
        }
    }
}

/// A colour over another of which it covers this part, in 25500ths.
fn mixed(under: u8, over: u8, part: u32) -> u8 {
    const WHOLE: u32 = 255 * 100;
    let part = part.min(WHOLE);
    let sum = u32::from(under) * (WHOLE - part) + u32::from(over) * part;
    // No more than 255, since it is between the two.
    ((sum + WHOLE / 2) / WHOLE) as u8
}

/// A path in pixels.
struct Path {
    commands: Vec<Command>,
    width: f64,
    height: f64,
}

impl Path {
    fn place(&self, (x, y): Place) -> Vector {
        let within = |pixel: f64, length: f64| {
            let pixel = if pixel.is_finite() { pixel } else { 0.0 };
            pixel.clamp(-BEYOND, length + BEYOND) as f32
        };
        Vector::new(
            within(x * SCALE, self.width),
            within(y * SCALE, self.height),
        )
    }

    fn line(&mut self, line: &[Place]) {
        for (index, place) in line.iter().enumerate() {
            let place = self.place(*place);
            self.commands.push(if index == 0 {
                Command::MoveTo(place)
            } else {
                Command::LineTo(place)
            });
        }
    }

    fn marker(&mut self, (x, y): Place, shape: Marker, radius: f64) {
        let at = |(dx, dy): Place| (x + dx * radius, y + dy * radius);
        let corners: Vec<Place> = shape.corners().iter().copied().map(at).collect();
        self.line(&corners);
        if shape == Marker::Disc {
            let q = QUARTER;
            let at = |dx: f64, dy: f64| self.place(at((dx, dy)));
            let circle = [
                Command::MoveTo(at(1.0, 0.0)),
                Command::CurveTo(at(1.0, q), at(q, 1.0), at(0.0, 1.0)),
                Command::CurveTo(at(-q, 1.0), at(-1.0, q), at(-1.0, 0.0)),
                Command::CurveTo(at(-1.0, -q), at(-q, -1.0), at(0.0, -1.0)),
                Command::CurveTo(at(q, -1.0), at(1.0, -q), at(1.0, 0.0)),
            ];
            self.commands.extend(circle);
        }
        self.commands.push(Command::Close);
    }

    /// A contour of a glyph: from a corner, or the middle between two control points, around to it.
    fn contour(&mut self, contour: &[Point], place: &impl Fn(f64, f64) -> Place) {
        let (Some(first), Some(last)) = (contour.first(), contour.last()) else {
            return;
        };
        let at = |point: Point| self.place(place(point.x, point.y));
        let start = match (first.is_corner, last.is_corner) {
            (true, _) => *first,
            (false, true) => *last,
            (false, false) => middle(*first, *last),
        };
        let mut commands = vec![Command::MoveTo(at(start))];
        let mut control: Option<Point> = None;
        for point in contour.iter().copied().chain([start]) {
            match (control, point.is_corner) {
                (None, true) => commands.push(Command::LineTo(at(point))),
                (Some(by), true) => commands.push(Command::QuadTo(at(by), at(point))),
                (Some(by), false) => {
                    commands.push(Command::QuadTo(at(by), at(middle(by, point))));
                }
                (None, false) => {}
            }
            control = (!point.is_corner).then_some(point);
        }
        commands.push(Command::Close);
        self.commands.extend(commands);
    }
}

fn middle(one: Point, other: Point) -> Point {
    Point {
        x: f64::midpoint(one.x, other.x),
        y: f64::midpoint(one.y, other.y),
        is_corner: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Layer;

    fn painted(shapes: Vec<Shape>) -> Canvas {
        Canvas::paint(&Scene {
            width: 30.0,
            height: 15.0,
            layers: vec![Layer { name: None, shapes }],
        })
    }

    fn area(corners: [Place; 4], opacity: Percent) -> Shape {
        Shape::Areas {
            areas: vec![corners.to_vec()],
            colour: Colour::Ink,
            opacity,
        }
    }

    #[test]
    fn an_area_covers_its_pixels_in_full_and_its_edge_in_part() {
        let edge = 3.0 + 0.5 / SCALE;
        let canvas = painted(vec![area(
            [(0.0, 0.0), (edge, 0.0), (edge, 6.0), (0.0, 6.0)],
            100,
        )]);
        assert_eq!((canvas.width, canvas.height), (80, 40));
        let row = &canvas.pixels[..canvas.width];
        assert_eq!((row[7], row[9]), (Colour::Ink.rgb(), Colour::Paper.rgb()));
        assert!((0x88..0x91).contains(&row[8][0]), "{:?}", row[8]);
        assert_eq!(canvas.pixels[16 * canvas.width], Colour::Paper.rgb());
    }

    #[test]
    fn what_reaches_over_the_edge_or_is_no_number_is_no_panic() {
        let far = [
            (-1e300, -1e9),
            (1e300, -1.0),
            (f64::NAN, 1e9),
            (-7.0, f64::INFINITY),
        ];
        let canvas = painted(vec![
            area(far, 50),
            area(
                [(-9.0, -9.0), (99.0, -9.0), (99.0, 99.0), (-9.0, 99.0)],
                100,
            ),
        ]);
        assert!(
            canvas
                .pixels
                .iter()
                .all(|pixel| *pixel == Colour::Ink.rgb())
        );
    }

    #[test]
    fn half_of_ink_over_paper_is_between_them() {
        assert_eq!(mixed(255, 0, 0), 255);
        assert_eq!(mixed(255, 0, 25_500), 0);
        assert_eq!(mixed(255, 0, 12_750), 128);
        assert_eq!(mixed(7, 7, 12_345), 7);
    }

    #[test]
    fn a_word_is_as_wide_as_it_is_laid_out_to_be() {
        for (anchor, at) in [
            (Anchor::Start, 2.0),
            (Anchor::End, 28.0),
            (Anchor::Middle, 15.0),
        ] {
            let text = Text::at((at, 11.0), 10.0, "HHH").anchor(anchor);
            let width = text::width("HHH", 10.0, false);
            let left = match anchor {
                Anchor::Start => at,
                Anchor::Middle => at - width / 2.0,
                Anchor::End => at - width,
            };
            let canvas = painted(vec![Shape::Text(text)]);
            let dark: Vec<f64> = (canvas.pixels.iter().enumerate())
                .filter(|(_, pixel)| pixel[0] < 0x60)
                .map(|(i, _)| (i % canvas.width) as f64 / SCALE)
                .collect();
            let first = dark.iter().copied().fold(f64::INFINITY, f64::min);
            let last = dark.iter().copied().fold(0.0, f64::max);
            assert!((left..left + 1.5).contains(&first), "{first} from {left}");
            let right = left + width;
            assert!((right - 1.8..right).contains(&last), "{last} to {right}");
        }
    }
}
