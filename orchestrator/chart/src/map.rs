//! A map of a value over two axes, before anything is drawn: a field of tiles.

use serde::Serialize;

use crate::axis::Axis;

/// A value at each crossing of a column and a row, drawn as a tile in the colour of its level.
///
/// There are at most nine levels, with round bounds, so that a value can be read off the legend. Maps
/// of one chart whose values have the same label share their levels; the first map sets their scale
/// and range. If all values fit into their tiles and nothing lies over the tiles, the values are
/// written into them.
///
/// A panel covers its map, or the ranges of its axes if they have any; what lies over the map is cut
/// to that. A map without a tile that shows anything counts as absent, except for its names: they are
/// on the axes at 0, 1, 2 and so on, whatever is drawn there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// What the tiles show. The label with its unit names the legend, `settling/s`. The scale sets
    /// the levels: even steps, or powers of ten and numbers between them. The range is what the
    /// levels cover: values beyond it are in the first or the last level, which is open in the
    /// legend.
    pub value: Axis,
    /// Positions of the columns.
    pub x: Along,
    /// Positions of the rows.
    pub y: Along,
    /// Row by row from the lowest, each from the left. A missing one is [`Tile::None`].
    pub tiles: Vec<Tile>,
    /// The name of hatched tiles in the legend and in CSV: `unstable`.
    pub hatched: &'static str,
}

/// Positions of a map's tiles along one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// The middles of the tiles in ascending order, evenly spaced or not. Tiles meet half-way, on the
    /// scale of the axis. A number that does not ascend, or that the axis cannot show, is left out
    /// with its tiles.
    Numbers(Vec<f64>),
    /// Names in this order; the scale and range of the axis do not apply. For what lies over the map
    /// they are at 0, 1, 2 and so on.
    Names(Vec<String>),
}

/// What is known at one crossing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tile {
    /// A value; if it is not finite, it counts as [`Tile::None`].
    Value(f64),
    /// No value, but the state that [`Map::hatched`] names.
    Hatched,
    /// Nothing is known: left blank.
    None,
}

impl Along {
    /// Number of columns or rows.
    pub(crate) fn count(&self) -> usize {
        match self {
            Along::Numbers(numbers) => numbers.len(),
            Along::Names(names) => names.len(),
        }
    }

    /// The names, if it has any.
    pub(crate) fn names(&self) -> &[String] {
        match self {
            Along::Numbers(_) => &[],
            Along::Names(names) => names,
        }
    }
}

impl Tile {
    /// The tile; [`Tile::None`] if its value cannot be drawn.
    pub(crate) fn drawable(self) -> Self {
        match self {
            Tile::Value(value) if !value.is_finite() => Tile::None,
            tile => tile,
        }
    }
}

impl Map {
    /// The tile of a column and a row, both from zero.
    pub(crate) fn tile(&self, column: usize, row: usize) -> Tile {
        let at = row * self.x.count() + column;
        self.tiles
            .get(at)
            .map_or(Tile::None, |tile| tile.drawable())
    }

    /// All tiles, row by row.
    pub(crate) fn all(&self) -> impl Iterator<Item = Tile> {
        let columns = 0..self.x.count();
        (0..self.y.count())
            .flat_map(move |row| columns.clone().map(move |column| self.tile(column, row)))
    }
}
