//! A chart as CSV: the numbers of exactly what is drawn, a row for each point.
//!
//! A panel is named by its letter, or where it has none by its number from 1. A row without x and
//! y is a gap in a line. A guide is a row, or two for one through two points; what it does not say
//! is empty.

use crate::chart::{Chart, GuideAt};
use crate::panel;

impl Chart {
    /// The points that the drawing shows, as `panel,series,x,y,low,high`; RFC 4180 with `\n`.
    ///
    /// Numbers are in the shortest form that reads back as the same number, in the axes' units.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let columns = crate::page::columns(self);
        let mut csv = String::from("panel,series,x,y,low,high\n");
        for (index, panel) in self.panels.iter().enumerate() {
            let panel_name = if panel.letter.is_empty() {
                (index + 1).to_string()
            } else {
                panel.letter.clone()
            };
            let mut row = |series: &str, numbers: [Option<f64>; 4]| {
                csv.push_str(&field(&panel_name));
                csv.push(',');
                csv.push_str(&field(series));
                for number in numbers {
                    csv.push(',');
                    csv.push_str(&number.map_or_else(String::new, shortest));
                }
                csv.push('\n');
            };
            for (series, points) in panel.series.iter().zip(panel::points(panel, columns)) {
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

/// With an exponent only where the plain form is long.
fn shortest(number: f64) -> String {
    format!("{number:?}")
}

/// Quoted if it has to be.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
