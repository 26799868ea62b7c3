//! The paper's figures, recomputed.
//!
//! Each is made of complete runs by a file of this folder; where there are none its panels say so.
//! How it is drawn is [`chart`]'s.

mod arrivals;
mod interval;
mod lateness;
mod median;
mod step;
mod tick;

use std::path::PathBuf;

use analysis::{Campaign, ReadError};
use chart::{Axis, Chart, Panel, Scale, Series};
use serde::Serialize;

/// A figure of the paper, and what it looks like here.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Its number in the paper: `3`.
    pub number: &'static str,
    /// What is drawn, in a sentence or two of ours.
    pub caption: String,
    /// What the paper's figure shows, beside which ours is to be read.
    pub paper: &'static str,
    /// What is drawn.
    pub chart: Chart,
    /// The cells that it came from, by id.
    pub runs: Vec<String>,
}

/// Figures 2 to 9, in order.
///
/// # Errors
/// [`ReadError`] where rows that a figure needs cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Figure>, ReadError> {
    Ok(vec![
        arrivals::figure(campaign)?,
        lateness::slow(campaign)?,
        lateness::fast(campaign)?,
        step::near(campaign)?,
        step::far(campaign)?,
        tick::figure(campaign)?,
        interval::near(campaign)?,
        interval::far(campaign)?,
    ])
}

impl Figure {
    /// Its files in a report's folder: `figures/fig-3.svg`, `.pdf` and `.csv`.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let path = |ending: &str| PathBuf::from(format!("figures/{}.{ending}", self.chart.name));
        vec![
            (path("svg"), self.chart.to_svg().into_bytes()),
            (path("pdf"), self.chart.to_pdf()),
            (path("csv"), self.chart.to_csv().into_bytes()),
        ]
    }
}

/// What stands in a panel without a complete run.
const NOT_RUN: &str = "not run";

/// A panel with linear axes as long as its data, and nothing in it yet.
fn panel(letter: &str, title: impl Into<String>, x: &str, y: &str) -> Panel {
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
        range: None,
    };
    Panel {
        letter: letter.to_owned(),
        title: title.into(),
        x: axis(x),
        y: axis(y),
        map: None,
        series: Vec::new(),
        guides: Vec::new(),
        empty: NOT_RUN.to_owned(),
    }
}

/// The text alternative, of a figure's sentences.
fn about(sentences: &[String]) -> String {
    match sentences.is_empty() {
        true => "Nothing has been run for this figure.".to_owned(),
        false => sentences.join(" "),
    }
}

/// Points without an interval about them.
fn series(name: String, mark: chart::Mark, role: chart::Role, points: Vec<(f64, f64)>) -> Series {
    Series {
        name,
        mark,
        role,
        points,
        band: Vec::new(),
    }
}
