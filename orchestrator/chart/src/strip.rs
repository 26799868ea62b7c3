//! The legend of a map: a strip with a swatch for each level and numbers where they meet.
//!
//! Beside it are samples of tiles without a level, if the map has any: hatched, and no data.

use crate::field::{corners, ground};
use crate::layout::{self, Frame, LEADING, LEGEND_SIZE, TICK_SIZE};
use crate::level::Levels;
use crate::palette::Colour;
use crate::scene::{Anchor, Layer, Place, Shape, Stroke, Text};
use crate::text;

/// A swatch: its greatest width, its least width in a legend of one row, and its height.
const WIDE: f64 = 21.0;
const NARROW: f64 = 13.0;
const HIGH: f64 = 7.5;

/// Width of the sample of tiles without a level.
const SAMPLE: f64 = 13.0;

/// Gap between a sample and its name.
const SPACE: f64 = 4.0;

/// Gap between the name, the strip, and the samples.
const GAP: f64 = 9.0;

/// Least gap between two numbers.
const APART: f64 = 3.0;

/// Length of the point of an open end.
const POINT: f64 = 4.0;

/// Distance from the swatches to the baseline of their numbers.
const NUMBERS_BELOW: f64 = 1.5 + TICK_SIZE * 0.85;

/// Height of a row: of one with names, and of that with the strip.
const ROW: f64 = LEGEND_SIZE * LEADING + 1.0;
const STRIP_ROW: f64 = HIGH + NUMBERS_BELOW + 5.0;

/// The legend of one quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strip<'a> {
    /// The label of the values.
    pub(crate) name: &'a str,
    pub(crate) levels: &'a Levels,
}

/// The parts of it that are side by side.
enum Block {
    Name(String),
    Levels { swatch: f64 },
    Hatched(&'static str),
    NoData,
}

impl Block {
    fn name(&self) -> &str {
        match self {
            Block::Name(name) => name,
            Block::Levels { .. } => "",
            Block::Hatched(name) => name,
            Block::NoData => "no data",
        }
    }

    /// Width of the part before its name.
    fn sample(&self) -> f64 {
        match self {
            Block::Name(_) | Block::Levels { .. } => 0.0,
            Block::Hatched(_) | Block::NoData => SAMPLE + SPACE,
        }
    }

    /// Font size of its name; smaller for a long one, so that it stays on the page.
    fn size(&self, room: f64) -> f64 {
        layout::fitting(self.name(), LEGEND_SIZE, room - self.sample())
    }

    /// Width with its name, but without the levels themselves.
    fn width(&self, room: f64) -> f64 {
        self.sample() + text::width(self.name(), self.size(room), false)
    }
}

impl Strip<'_> {
    fn blocks(&self, room: f64) -> Vec<Block> {
        let note = match self.levels.note.as_str() {
            "" => String::new(),
            note => format!(" ({note})"),
        };
        let name = format!("{}{note}", self.name);
        let before = (!name.is_empty()).then_some(Block::Name(name));
        let after = [
            self.levels.hatched.map(Block::Hatched),
            self.levels.has_blank.then_some(Block::NoData),
        ];
        let others = before.iter().chain(after.iter().flatten());
        let beside: f64 = others.map(|block| block.width(room) + GAP).sum();
        let count = self.levels.count();
        let swatch = |room: f64| (room - 2.0 * self.overhang()) / count as f64;
        let swatch = match swatch(room - beside) {
            in_one_row if in_one_row >= NARROW => in_one_row,
            _ => swatch(room),
        };
        let levels = (count > 0).then_some(Block::Levels {
            swatch: swatch.clamp(1.0, WIDE),
        });
        let blocks = before.into_iter().chain(levels);
        blocks.chain(after.into_iter().flatten()).collect()
    }

    /// How far a number may extend beyond the end of the strip.
    fn overhang(&self) -> f64 {
        let labels = [self.levels.bounds.first(), self.levels.bounds.last()];
        let widths = labels.iter().flatten().map(|(_, label)| wide(label) / 2.0);
        widths.fold(POINT, f64::max)
    }

    /// The blocks, each with its place as (x, y), and their height together.
    fn places(&self, room: f64) -> (Vec<(Block, Place)>, f64) {
        let blocks = self.blocks(room);
        let widths: Vec<f64> = blocks
            .iter()
            .map(|block| match block {
                Block::Levels { swatch } => {
                    swatch * self.levels.count() as f64 + 2.0 * self.overhang()
                }
                block => block.width(room),
            })
            .collect();
        let (places, rows) = layout::flow(&widths, GAP, room);
        let strip_row = blocks
            .iter()
            .zip(&places)
            .find(|(block, _)| matches!(block, Block::Levels { .. }))
            .map(|(_, (_, row))| *row);
        let high = |row: usize| {
            if Some(row) == strip_row {
                STRIP_ROW
            } else {
                ROW
            }
        };
        let top = |row: usize| (0..row).map(high).sum::<f64>();
        let places = places.iter().map(|(x, row)| (*x, top(*row)));
        (blocks.into_iter().zip(places).collect(), top(rows))
    }

    /// Its height in this width.
    pub(crate) fn height(&self, room: f64) -> f64 {
        self.places(room).1
    }

    /// Draws it from its top left corner.
    pub(crate) fn draw(&self, at: Place, room: f64) -> Layer {
        let mut shapes = Vec::new();
        for (block, (x, y)) in self.places(room).0 {
            let (left, top) = (at.0 + x, at.1 + y + 1.0);
            let sample = Frame {
                left,
                top,
                width: SAMPLE,
                height: HIGH,
            };
            match &block {
                Block::Name(_) => {}
                Block::Levels { swatch } => {
                    self.levels((left + self.overhang(), top), *swatch, &mut shapes);
                }
                Block::Hatched(_) => shapes.extend(ground(&[sample], &[sample])),
                Block::NoData => shapes.push(outline(&sample)),
            }
            if !block.name().is_empty() {
                let size = block.size(room);
                let base = (left + block.sample(), top + HIGH / 2.0 + size * 0.34);
                shapes.push(Shape::Text(Text::at(base, size, block.name())));
            }
        }
        Layer { name: None, shapes }
    }

    /// Adds the swatches and their numbers.
    fn levels(&self, at: Place, swatch: f64, shapes: &mut Vec<Shape>) {
        let levels = self.levels;
        let (left, top) = at;
        let (middle, bottom) = (top + HIGH / 2.0, top + HIGH);
        let right = left + swatch * levels.count() as f64;
        // Each continues under those that follow, as the areas of a map do.
        for level in 0..levels.count() {
            let start = left + swatch * level as f64;
            let mut area = if level == 0 && levels.is_open_below {
                vec![(start, bottom), (start - POINT, middle), (start, top)]
            } else {
                vec![(start, bottom), (start, top)]
            };
            area.push((right, top));
            if levels.is_open_above {
                area.push((right + POINT, middle));
            }
            area.push((right, bottom));
            shapes.push(Shape::Areas {
                areas: vec![area],
                colour: levels.colour(level),
                opacity: 100,
            });
        }
        let last = levels.count();
        let bounds: Vec<(f64, &str)> = levels
            .bounds
            .iter()
            .enumerate()
            .filter(|(bound, _)| *bound > 0 || !levels.is_open_below)
            .filter(|(bound, _)| *bound < last || !levels.is_open_above)
            .map(|(bound, (_, label))| (left + swatch * bound as f64, label.as_str()))
            .collect();
        let fits = |every: &usize| {
            let shown: Vec<_> = bounds.iter().step_by(*every).collect();
            shown
                .iter()
                .zip(shown.iter().skip(1))
                .all(|(a, b)| a.0 + wide(a.1) / 2.0 + APART <= b.0 - wide(b.1) / 2.0)
        };
        let every = (1..=bounds.len()).find(fits).unwrap_or(1);
        let mut ticks = Vec::new();
        for (x, label) in bounds.iter().step_by(every) {
            ticks.push(vec![(*x, bottom), (*x, bottom + 1.5)]);
            let number = Text::at((*x, bottom + NUMBERS_BELOW), TICK_SIZE, *label);
            shapes.push(Shape::Text(number.anchor(Anchor::Middle)));
        }
        shapes.push(Shape::Lines {
            lines: ticks,
            stroke: Stroke::solid(Colour::Ink, 0.5),
        });
    }
}

fn wide(label: &str) -> f64 {
    text::width(label, TICK_SIZE, false)
}

/// The outline of a rectangle.
fn outline(room: &Frame) -> Shape {
    let mut line = corners(room);
    line.extend(line.first().copied());
    Shape::Lines {
        lines: vec![line],
        stroke: Stroke {
            opacity: 60,
            ..Stroke::solid(Colour::Ink, 0.5)
        },
    }
}
