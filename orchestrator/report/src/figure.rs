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
use chart::{Axis, Chart, Panel, Scale};
use plan::Verdict;
use serde::Serialize;

use crate::origin::Origin;
use crate::subject::TONES;

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
    let mut figures = vec![
        arrivals::figure(campaign)?,
        lateness::slow(campaign)?,
        lateness::fast(campaign)?,
        step::near(campaign)?,
        step::far(campaign)?,
        tick::figure(campaign)?,
        interval::near(campaign)?,
        interval::far(campaign)?,
    ];
    if let Some(words) = disturbed(campaign) {
        for figure in &mut figures {
            figure.caption += &format!(" {words}");
        }
    }
    if campaign.is_simulated() {
        for figure in &mut figures {
            figure.chart.title += ", simulated";
            figure.caption = format!("Simulated, in virtual time. {}", figure.caption);
        }
    }
    Ok(figures)
}

/// Which runs are in no figure since something disturbed them, with what and when.
fn disturbed(campaign: &Campaign) -> Option<String> {
    /// Of more than these it is enough to know how many.
    const NAMED: usize = 3;
    let marked = campaign
        .runs
        .iter()
        .filter(|run| run.verdict() == Some(Verdict::Disturbed));
    let marked: Vec<String> = marked
        .map(|run| {
            let what = run.summary.disturbed.as_deref().unwrap_or("disturbed");
            format!("{} ({what})", run.cell.id)
        })
        .collect();
    let more = match marked.len() {
        0 => return None,
        all if all > NAMED => format!(" and {} more", all - NAMED),
        _ => String::new(),
    };
    let named = marked[..marked.len().min(NAMED)].join(", ");
    Some(format!(
        "Left out, since something disturbed them: {named}{more}."
    ))
}

impl Figure {
    /// Of so many columns, with nothing drawn yet.
    fn new(
        number: &'static str,
        title: &str,
        columns: usize,
        caption: &str,
        paper: &'static str,
    ) -> Figure {
        Figure {
            number,
            caption: caption.to_owned(),
            paper,
            chart: Chart {
                tones: &TONES,
                name: format!("fig-{number}"),
                title: title.to_owned(),
                about: String::new(),
                source: String::new(),
                columns,
                panels: Vec::new(),
            },
            runs: Vec::new(),
        }
    }

    /// With its panels, what they show in sentences, and where that came from.
    fn drawn(
        mut self,
        panels: Vec<Panel>,
        sentences: &[String],
        origin: &Origin<'_>,
        campaign: &Campaign,
    ) -> Figure {
        self.chart.panels = panels;
        self.chart.about = match sentences {
            [] => "Nothing has been run for this figure.".to_owned(),
            _ => sentences.join(" "),
        };
        self.chart.source = origin.line(campaign);
        self.runs = origin.ids();
        self
    }

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
    let axis = |label| Axis::new(label, Scale::Linear);
    Panel {
        letter: letter.to_owned(),
        title: title.into(),
        ..Panel::new(axis(x), axis(y), NOT_RUN)
    }
}
