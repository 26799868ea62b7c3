//! What a figure shows, before anything is drawn.

use serde::Serialize;

use crate::axis::Axis;
use crate::map::Map;

/// A figure of one or more panels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// What its files are called: `fig-3`.
    pub name: String,
    /// Heading of the figure.
    pub title: String,
    /// What there is to see, for those who cannot: the text alternative.
    pub about: String,
    /// Where it came from: runs, seed, back-end, player. Printed small below the panels.
    pub source: String,
    /// The tones that a page may set, of this chart's series or not.
    pub tones: &'static [Tone],
    /// How many panels stand side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// One pair of axes and what is drawn in it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Panel {
    /// Its letter in the paper, `a`; empty where there is only one.
    pub letter: String,
    /// Its heading, after the letter.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// A value over both axes, under everything else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Map>,
    /// What is drawn, the last on top.
    pub series: Vec<Series>,
    /// Lines that are no data: references, the paper's values.
    pub guides: Vec<Guide>,
    /// What is printed in the panel's place where there is nothing to draw: `not run`.
    pub empty: String,
}

impl Panel {
    /// With nothing in it yet.
    #[must_use]
    pub fn new(x: Axis, y: Axis, empty: &str) -> Panel {
        Panel {
            letter: String::new(),
            title: String::new(),
            x,
            y,
            map: None,
            series: Vec::new(),
            guides: Vec::new(),
            empty: empty.to_owned(),
        }
    }
}

/// One set of points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Its tone: colour, dash and marker.
    pub tone: Tone,
    /// The points, x and y.
    pub points: Vec<(f64, f64)>,
    /// Below and above each point, as long as `points` or empty: an interval, drawn as a band or as
    /// whiskers.
    pub band: Vec<(f64, f64)>,
}

impl Series {
    /// Points without an interval about them.
    #[must_use]
    pub fn new(name: String, mark: Mark, tone: Tone, points: Vec<(f64, f64)>) -> Series {
        Series {
            name,
            mark,
            tone,
            points,
            band: Vec::new(),
        }
    }
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// Joined by straight lines.
    Line,
    /// Joined by steps that hold until the next.
    Steps,
    /// Drawn as dots.
    Dots,
    /// Bars of this width about x, from zero to y.
    Bars(f64),
}

/// What a series is drawn in: a colour, and for print in grey its place among dashes and markers. Whose it
/// is, the caller says; the same in all figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Tone {
    /// The last part of its CSS variable, `--chart-` before it, and of its classes: letters, digits, `-`.
    pub name: &'static str,
    /// Red, green and blue on white paper.
    pub rgb: [u8; 3],
    /// Number of its first dash and marker: 0 is a solid line, and discs.
    pub dash: u8,
}

/// A line across a panel that is no data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Guide {
    /// What it is: `the paper: 3.004 ms`.
    pub name: String,
    /// Where it is.
    pub at: GuideAt,
}

/// Where a guide is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GuideAt {
    /// Level, at this y.
    Y(f64),
    /// Upright, at this x.
    X(f64),
    /// Through two points, across the panel.
    Line((f64, f64), (f64, f64)),
}
