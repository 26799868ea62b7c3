//! A chart as CSV: exactly the numbers that are drawn, one row per point.
//!
//! A panel is named by its letter, or by its number from 1 if it has none. A row without x and y is a
//! gap in a line. A guide is one row, or two if it goes through two points; a coordinate that it does
//! not have is empty. A tile of a map is a row too, with the middles or the names of its column and
//! row. In all other rows, positions on an axis of names count from 0.

use crate::chart::{GuideAt, Panel};
use crate::drawing::Drawing;
use crate::extent;
use crate::grid::{self, Lane};
use crate::map::{Along, Tile};

impl Drawing<'_> {
    /// The points that the drawing shows, as `panel,series,x,y,low,high`; RFC 4180 with `\n` as line
    /// end.
    ///
    /// If a panel has a map, there are two more columns: `value,state`. A tile's series is the label
    /// of the map's values, and its state is `value`, `none` or the map's name for hatched tiles.
    ///
    /// Numbers are in the shortest form that reads back as the same number, in the axes' units.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let panels = &self.chart.panels;
        let has_maps = panels.iter().any(|panel| grid::map(panel).is_some());
        let mut csv = String::from("panel,series,x,y,low,high");
        csv.push_str(if has_maps { ",value,state\n" } else { "\n" });
        for (index, panel) in panels.iter().enumerate() {
            let panel_name = if panel.letter.is_empty() {
                (index + 1).to_string()
            } else {
                panel.letter.clone()
            };
            for tile in tiles(panel) {
                csv.push_str(&field(&panel_name));
                csv.push(',');
                csv.push_str(&tile);
                csv.push('\n');
            }
            let mut row = |series: &str, numbers: [Option<f64>; 4]| {
                csv.push_str(&field(&panel_name));
                csv.push(',');
                csv.push_str(&field(series));
                for number in numbers {
                    csv.push(',');
                    csv.push_str(&number.map_or_else(String::new, shortest));
                }
                csv.push_str(if has_maps { ",,\n" } else { "\n" });
            };
            for (series, points) in panel.series.iter().zip(&self.points[index]) {
                for point in points {
                    if point.after_gap {
                        row(&series.name, [None; 4]);
                    }
                    let (x, y) = point.value;
                    let (low, high) = point.band.unzip();
                    row(&series.name, [Some(x), Some(y), low, high]);
                }
            }
            for guide in &panel.guides {
                match guide.at {
                    GuideAt::X(x) => row(&guide.name, [Some(x), None, None, None]),
                    GuideAt::Y(y) => row(&guide.name, [None, Some(y), None, None]),
                    GuideAt::Line(a, b) => {
                        for (x, y) in [a, b] {
                            row(&guide.name, [Some(x), Some(y), None, None]);
                        }
                    }
                }
            }
        }
        csv
    }
}

/// The CSV rows of a panel's map, without the panel's name: from the lowest row of tiles, each from
/// the left.
fn tiles(panel: &Panel) -> Vec<String> {
    let (Some(map), Some((x, y))) = (grid::map(panel), extent::of(panel)) else {
        return Vec::new();
    };
    let name = field(&map.value.label);
    let at = |along: &Along, lane: &Lane| match along.names().get(lane.index) {
        Some(name) => field(name),
        None => shortest(lane.middle),
    };
    let columns = grid::seen(&map.x, &x);
    let mut tiles = Vec::new();
    for row in grid::seen(&map.y, &y) {
        for column in &columns {
            let (x, y) = (at(&map.x, column), at(&map.y, &row));
            let state = match map.tile(column.index, row.index) {
                Tile::Value(value) => format!("{},value", shortest(value)),
                Tile::Hatched => format!(",{}", field(map.hatched)),
                Tile::None => ",none".to_owned(),
            };
            tiles.push(format!("{name},{x},{y},,,{state}"));
        }
    }
    tiles
}

/// A number in its shortest form, with an exponent only if the plain form is long.
fn shortest(number: f64) -> String {
    format!("{number:?}")
}

/// A field, quoted if it has to be.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
