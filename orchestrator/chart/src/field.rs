//! Turns the tiles of a map into shapes: areas of one level each.
//!
//! Areas are stacked: each covers its level and all above it, and the next is drawn on top. So no
//! paper shows between two colours, whatever program draws them.

use crate::grid::{self, Lane};
use crate::hatch::hatch;
use crate::layout::{Frame, TICK_SIZE};
use crate::level::Levels;
use crate::map::{Map, Tile};
use crate::palette::Colour;
use crate::scene::{Anchor, Layer, Place, Shape, Stroke, Text};
use crate::span::Span;
use crate::{text, tick};

/// Opacity of the ground under hatching, %.
const GROUND: u8 = 12;

/// Free space on either side of a value in its tile.
const BESIDE_VALUE: f64 = 3.0;

/// What one tile shows, the lowest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum TileFill {
    Nothing,
    Hatched,
    Level(usize),
}

/// The tiles of a map that are in a panel.
pub(crate) struct Field<'a> {
    map: &'a Map,
    levels: &'a Levels,
    /// Lanes whose ends are positions on the page: left and right, top and bottom.
    columns: Vec<Lane>,
    rows: Vec<Lane>,
}

impl<'a> Field<'a> {
    /// A map in this box, with these axes.
    pub(crate) fn of(
        map: &'a Map,
        levels: &'a Levels,
        frame: &Frame,
        (x, y): (&Span, &Span),
    ) -> Self {
        let across = |at: f64| frame.place((at, 0.0)).0;
        let down = |at: f64| frame.place((0.0, at)).1;
        let columns = grid::seen(&map.x, x).into_iter().map(|lane| Lane {
            from: across(lane.from),
            to: across(lane.to),
            ..lane
        });
        let rows = grid::seen(&map.y, y).into_iter().map(|lane| Lane {
            from: down(lane.to),
            to: down(lane.from),
            ..lane
        });
        Field {
            map,
            levels,
            columns: columns.collect(),
            rows: rows.collect(),
        }
    }

    fn tile(&self, column: &Lane, row: &Lane) -> Tile {
        self.map.tile(column.index, row.index)
    }

    fn shown(&self, column: &Lane, row: &Lane) -> TileFill {
        match self.tile(column, row) {
            Tile::Value(value) => TileFill::Level(self.levels.at(value)),
            Tile::Hatched => TileFill::Hatched,
            Tile::None => TileFill::Nothing,
        }
    }

    /// The hatched ground, then level by level.
    pub(crate) fn layers(&self) -> Vec<Layer> {
        let mut layers = Vec::new();
        if self.has(TileFill::Hatched) {
            let all = self.rooms(|shown| shown >= TileFill::Hatched);
            let hatched = self.rooms(|shown| shown == TileFill::Hatched);
            layers.push(Layer {
                name: Some(self.map.hatched.to_owned()),
                shapes: ground(&all, &hatched),
            });
        }
        for level in (0..self.levels.count()).filter(|level| self.has(TileFill::Level(*level))) {
            let rooms = self.rooms(|shown| shown >= TileFill::Level(level));
            layers.push(Layer {
                name: Some(format!(
                    "{}: {}",
                    self.map.value.label,
                    self.levels.name(level)
                )),
                shapes: vec![Shape::Areas {
                    areas: rooms.iter().map(corners).collect(),
                    colour: self.levels.colour(level),
                    opacity: 100,
                }],
            });
        }
        layers
    }

    /// The values, each in its tile; none if one of them does not fit.
    pub(crate) fn values(&self) -> Layer {
        let mut shapes = Vec::new();
        for row in &self.rows {
            for column in &self.columns {
                let Tile::Value(value) = self.tile(column, row) else {
                    continue;
                };
                let label = tick::short(value);
                let needed = text::width(&label, TICK_SIZE, false) + 2.0 * BESIDE_VALUE;
                if column.to - column.from < needed || row.to - row.from < TICK_SIZE * 1.6 {
                    return Layer::default();
                }
                let base = (row.from + row.to) / 2.0 + TICK_SIZE * 0.34;
                let at = ((column.from + column.to) / 2.0, base);
                let over = self.levels.colour_over(self.levels.at(value));
                let value = Text::at(at, TICK_SIZE, label);
                shapes.push(Shape::Text(value.anchor(Anchor::Middle).colour(over)));
            }
        }
        Layer { name: None, shapes }
    }

    fn has(&self, what: TileFill) -> bool {
        self.rows.iter().any(|row| {
            let mut columns = self.columns.iter();
            columns.any(|column| self.shown(column, row) == what)
        })
    }

    /// The tiles for which `is_so` holds, as rectangles: runs of tiles in a row, joined with runs of
    /// the same left end and width in the rows above.
    fn rooms(&self, is_so: impl Fn(TileFill) -> bool) -> Vec<Frame> {
        let (mut done, mut open) = (Vec::new(), Vec::<Frame>::new());
        for row in &self.rows {
            let tiles: Vec<(bool, &Lane)> = self
                .columns
                .iter()
                .map(|column| (is_so(self.shown(column, row)), column))
                .collect();
            let mut of_row: Vec<Frame> = tiles
                .chunk_by(|a, b| a.0 == b.0)
                .filter_map(|run| match (run.first()?, run.last()?) {
                    ((true, first), (_, last)) => Some(Frame {
                        left: first.from,
                        top: row.from,
                        width: last.to - first.from,
                        height: row.to - row.from,
                    }),
                    _ => None,
                })
                .collect();
            for room in open {
                let same = of_row
                    .iter_mut()
                    .find(|above| above.left == room.left && above.width == room.width);
                match same {
                    Some(above) => above.height = room.bottom() - above.top,
                    None => done.push(room),
                }
            }
            open = of_row;
        }
        done.append(&mut open);
        done
    }
}

/// Ground under `all`, with hatching over `hatched`.
pub(crate) fn ground(all: &[Frame], hatched: &[Frame]) -> Vec<Shape> {
    vec![
        Shape::Areas {
            areas: all.iter().map(corners).collect(),
            colour: Colour::Ink,
            opacity: GROUND,
        },
        Shape::Lines {
            lines: hatch(hatched),
            stroke: Stroke {
                opacity: 60,
                ..Stroke::solid(Colour::Ink, 0.6)
            },
        },
    ]
}

/// A rectangle's corners.
pub(crate) fn corners(room: &Frame) -> Vec<Place> {
    vec![
        (room.left, room.top),
        (room.right(), room.top),
        (room.right(), room.bottom()),
        (room.left, room.bottom()),
    ]
}
