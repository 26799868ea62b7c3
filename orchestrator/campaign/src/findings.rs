//! The findings of a sweep: summary, borders and maps, computed from its rows and stored beside them.

use chart::Chart;
use sweep::{Axis, Border, Cell, Limit, Row, Sweep};

use crate::error::Error;
use crate::sweep_folder::SweepFolder;

/// Findings of a sweep.
#[derive(Debug)]
pub struct Findings {
    /// The summary in words.
    pub summary: String,
    /// The borders as CSV; `None` if there are none.
    margins: Option<String>,
    /// The maps.
    pub maps: Vec<Chart>,
}

impl Findings {
    /// Computes the findings of a sweep of which all rows are there.
    #[must_use]
    pub fn of(sweep: &Sweep, rows: &[Row]) -> Findings {
        let cells = Cell::all(sweep, rows);
        let borders = sweep::borders(sweep, &cells);
        Findings {
            summary: sweep::summary(sweep, &cells, &borders),
            margins: (!borders.is_empty()).then(|| margins(sweep, &borders)),
            maps: sweep::maps(sweep, &cells, &borders),
        }
    }

    /// Writes them into the sweep's folder.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn leave(&self, folder: &SweepFolder<'_>) -> Result<(), Error> {
        folder.leave("findings.txt", self.summary.as_bytes())?;
        if let Some(margins) = &self.margins {
            folder.leave("margins.csv", margins.as_bytes())?;
        }
        for map in &self.maps {
            let name = |ending: &str| format!("maps/{}.{ending}", map.name);
            let drawing = map.draw();
            folder.leave(&name("svg"), drawing.to_svg().as_bytes())?;
            folder.leave(&name("pdf"), &drawing.to_pdf())?;
            folder.leave(&name("csv"), drawing.to_csv().as_bytes())?;
        }
        Ok(())
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
