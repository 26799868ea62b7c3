//! The paper's figures, recomputed, and the step responses of what is not the paper's.
//!
//! Each is made from complete runs by a file of this folder; a panel without any says so. [`chart`]
//! draws them.

mod budget;
mod distribution;
mod fault;
pub mod median;
mod reach;
mod response;
mod scale;
mod schedule;
pub mod step;
mod worst;

use std::path::PathBuf;

use analysis::Campaign;
use chart::{Axis, Chart, Drawing, Panel, Scale};
use plan::Verdict;
use record::ReadError;
use serde::Serialize;

use self::median::Traces;
use crate::called::called;
use crate::delays::{Delays, Nearest};
use crate::origin::Origin;
use crate::tone::{TONES, TONES_WITH_PARTS};

/// A figure of the paper, recomputed, or of one's own runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Its number in the paper, `3`, or a letter.
    pub number: &'static str,
    /// What is drawn, in our words.
    pub caption: String,
    /// What the paper's figure shows, for comparison; `None` if the paper has none.
    pub paper: Option<&'static str>,
    /// The drawing.
    pub chart: Chart,
    /// Ids of the cells that it is made from.
    pub runs: Vec<String>,
}

/// A figure laid out once, for the page and for its files.
#[derive(Debug)]
pub struct LaidOut<'a> {
    /// What is drawn.
    pub figure: &'a Figure,
    /// The drawing as SVG.
    pub svg: String,
    drawing: Drawing<'a>,
}

/// The figures of any experiment, by what there is to show in it; `delays` and `nearest` are of the same
/// campaign.
///
/// # Errors
/// [`ReadError`] if rows that a figure needs cannot be read.
pub fn all(
    campaign: &Campaign,
    delays: &[Delays<'_>],
    nearest: Option<&Nearest<'_>>,
) -> Result<Vec<Figure>, ReadError> {
    let mut read = delays.iter();
    let mut traces = Traces::with(read.find_map(|of| Some((of.worst.0, of.response.as_ref()?))));
    let mut figures = response::figures(campaign, &mut traces)?;
    figures.extend(schedule::figure(campaign)?);
    figures.extend(fault::figure(campaign));
    figures.extend(distribution::figure(delays, campaign));
    figures.extend(budget::medians(delays, campaign));
    figures.extend(budget::samples(delays, campaign));
    if let Some(nearest) = nearest {
        figures.push(worst::figure(campaign, nearest, &mut traces)?);
    }
    figures.sort_by_key(|figure| figure.number);
    Ok(figures)
}

/// Says in each figure what holds for all of them: which runs are left out, and that they are simulated.
pub(crate) fn annotate(figures: &mut [Figure], campaign: &Campaign) {
    if let Some(words) = disturbed(campaign) {
        for figure in &mut *figures {
            figure.caption += &format!(" {words}");
        }
    }
    if campaign.is_simulated() {
        for figure in figures {
            figure.chart.title += ", simulated";
            figure.caption = format!("Simulated, in virtual time. {}", figure.caption);
        }
    }
}

/// A sentence on the runs that are in no figure because they were disturbed, with what disturbed them
/// and when.
fn disturbed(campaign: &Campaign) -> Option<String> {
    /// The most runs that are named; further ones are only counted.
    const NAMED: usize = 3;
    let marked = campaign
        .runs
        .iter()
        .filter(|run| run.verdict() == Some(Verdict::Disturbed));
    let marked: Vec<String> = marked
        .map(|run| {
            let what = run.summary.disturbed.as_deref().unwrap_or("disturbed");
            format!("{} ({what})", called(campaign, run))
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
    /// A figure with this number of columns, and nothing drawn yet.
    #[must_use]
    pub fn new(
        number: &'static str,
        title: &str,
        columns: usize,
        caption: &str,
        paper: Option<&'static str>,
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

    /// The same figure, whose series also have the colours of the parts of a delay.
    #[must_use]
    pub fn with_parts(mut self) -> Figure {
        self.chart.tones = &TONES_WITH_PARTS;
        self
    }

    /// Adds the panels, what they show in sentences, and where the data came from.
    #[must_use]
    pub fn drawn(
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

    /// The figure laid out.
    #[must_use]
    pub fn draw(&self) -> LaidOut<'_> {
        let drawing = self.chart.draw();
        LaidOut {
            figure: self,
            svg: drawing.to_svg(),
            drawing,
        }
    }
}

impl LaidOut<'_> {
    /// Its picture for slides, `figures/fig-3.png`. To paint it takes several times as long as all of
    /// [`LaidOut::files`].
    #[must_use]
    pub fn picture(&self) -> (PathBuf, Vec<u8>) {
        let path = format!("figures/{}.png", self.figure.chart.name);
        (PathBuf::from(path), self.drawing.to_png())
    }

    /// Its files in a report's folder: `figures/fig-3.svg`, `.pdf` and `.csv`.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let name = &self.figure.chart.name;
        let path = |ending: &str| PathBuf::from(format!("figures/{name}.{ending}"));
        vec![
            (path("svg"), self.svg.clone().into_bytes()),
            (path("pdf"), self.drawing.to_pdf()),
            (path("csv"), self.drawing.to_csv().into_bytes()),
        ]
    }
}

/// The text in a panel without a complete run.
const NOT_RUN: &str = "not run";

/// A panel with linear axes in the range of its data, and nothing in it yet.
#[must_use]
pub fn panel(letter: &str, title: impl Into<String>, x: &str, y: &str) -> Panel {
    let axis = |label| Axis::new(label, Scale::Linear);
    Panel {
        letter: letter.to_owned(),
        title: title.into(),
        ..Panel::new(axis(x), axis(y), NOT_RUN)
    }
}
