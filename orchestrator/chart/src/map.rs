//! A value over two axes, before anything is drawn: a field of tiles.

use serde::Serialize;

use crate::axis::Axis;

/// A value at each crossing of a column and a row, drawn as a tile in the colour of its level.
///
/// There are at most nine levels, with round bounds, so that a value can be read off the legend.
/// Maps of one chart whose values have the same label share their levels; the first of them says how
/// they follow each other. Where every tile has room, and nothing lies over them, the values are
/// written into them, too.
///
/// A panel is as large as its map, or as its axes' ranges say, and what lies over the map is cut to
/// that. Without a tile that shows anything the map counts as not there, but for its names:
/// they stand along the axes at 0, 1, 2 and so on, whatever is drawn there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// What the tiles say. The label with its unit names the legend, `settling/s`; by the scale levels
    /// follow each other in even steps or by powers of ten and what is between them. A range is what
    /// the levels cover: what is beyond it is in the first or the last of them, open in the legend.
    pub value: Axis,
    /// Where the columns are.
    pub x: Along,
    /// Where the rows are.
    pub y: Along,
    /// Row by row from the lowest, each from the left. What is missing is [`Tile::None`].
    pub tiles: Vec<Tile>,
    /// What a hatched tile is, in the legend and in CSV: `unstable`.
    pub hatched: &'static str,
}

/// Where the tiles of a map are along one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// The tiles' middles, rising, evenly or not; tiles meet half-way, on the axis's scale. What does
    /// not rise or cannot be on the axis is left out with its tiles.
    Numbers(Vec<f64>),
    /// Names in this order, with no regard to the axis's scale and range. For what lies over the map
    /// they are at 0, 1, 2 and so on.
    Names(Vec<String>),
}

/// What there is to say at one crossing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tile {
    /// A value; what is no finite number counts as [`Tile::None`].
    Value(f64),
    /// No value, and something to say all the same, which is [`Map::hatched`].
    Hatched,
    /// Nothing is known: left blank.
    None,
}

impl Along {
    /// How many columns or rows there are.
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
    /// The tile; without a value if its number cannot be drawn.
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

    /// Every tile, in the order of columns and rows.
    pub(crate) fn all(&self) -> impl Iterator<Item = Tile> {
        let columns = 0..self.x.count();
        (0..self.y.count())
            .flat_map(move |row| columns.clone().map(move |column| self.tile(column, row)))
    }
}
