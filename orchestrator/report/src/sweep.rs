//! The report on a sweep: its findings in words, its borders, its maps, and a page of them, all made of its rows.

mod map;

use std::path::PathBuf;

use analysis::sweep::{Border, Limit, PointRuns, Row, borders, summary};
use chart::Chart;
use plan::sweep::{Axis, Sweep};

use crate::page;

pub use map::maps;

/// The page, in the sweep's folder.
pub const PAGE: &str = "report.html";

/// The report on a sweep.
#[derive(Debug)]
pub struct SweepReport<'a> {
    sweep: &'a Sweep,
    /// The findings in words.
    pub summary: String,
    /// The borders as CSV; `None` if there are none.
    margins: Option<String>,
    maps: Vec<Chart>,
}

impl<'a> SweepReport<'a> {
    /// The report on a sweep of which all rows are there.
    #[must_use]
    pub fn of(sweep: &'a Sweep, rows: &[Row]) -> SweepReport<'a> {
        let points = PointRuns::all(sweep, rows);
        let borders = borders(sweep, &points);
        SweepReport {
            sweep,
            summary: summary(sweep, &points, &borders),
            margins: (!borders.is_empty()).then(|| margins(sweep, &borders)),
            maps: maps(sweep, &points, &borders),
        }
    }

    /// Every file of the report: its name and its content.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let drawn: Vec<_> = self.maps.iter().map(|map| (map, map.draw())).collect();
        let svgs: Vec<_> = drawn
            .iter()
            .map(|(map, drawing)| (*map, drawing.to_svg()))
            .collect();
        let page = page::sweep(self.sweep, &self.summary, &svgs);
        let mut files = vec![
            ("findings.txt".into(), self.summary.clone().into_bytes()),
            (PAGE.into(), page.into_bytes()),
        ];
        if let Some(margins) = &self.margins {
            files.push(("margins.csv".into(), margins.clone().into_bytes()));
        }
        for ((map, drawing), (_, svg)) in drawn.iter().zip(svgs) {
            let name = |ending: &str| format!("maps/{}.{ending}", map.name).into();
            files.push((name("svg"), svg.into_bytes()));
            files.push((name("pdf"), drawing.to_pdf()));
            files.push((name("csv"), drawing.to_csv().into_bytes()));
        }
        files
    }
}

/// The borders as CSV: a row for each combination of the other axes.
fn margins(sweep: &Sweep, borders: &[Border]) -> String {
    let dimensions = sweep.grid.dimensions();
    let others = || {
        let all = dimensions.iter().enumerate();
        all.filter(|(_, d)| d.axis != Axis::Rtt)
    };
    let mut lines: Vec<String> = others().map(|(_, d)| d.axis.column().to_owned()).collect();
    lines.extend(["found_ms", "lost_ms", "computed_ms", "off_ms"].map(str::to_owned));
    let mut csv = lines.join(",") + "\n";
    let figure = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    for border in borders {
        let mut line: Vec<String> = others()
            .map(|(at, d)| d.levels[border.place[at]].text.clone())
            .collect();
        line.push(figure(border.found_ms));
        line.push(figure(border.lost_ms));
        line.push(match border.limit {
            Limit::Unknown => String::new(),
            Limit::None => "none".to_owned(),
            Limit::Until(ms) => ms.to_string(),
        });
        line.push(figure(border.off_ms()));
        csv += &line.join(",");
        csv.push('\n');
    }
    csv
}
