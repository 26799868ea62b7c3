//! What a figure shows, before anything is drawn.

use serde::Serialize;

use crate::axis::Axis;
use crate::map::Map;

/// A figure of one or more panels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Name of its files: `fig-3`.
    pub name: String,
    /// Heading of the figure.
    pub title: String,
    /// The text alternative: what the figure shows, for those who cannot see it.
    pub about: String,
    /// Where it came from: runs, seed, back-end, player. Printed small below the panels.
    pub source: String,
    /// The tones that a page may set, whether this chart's series use them or not.
    pub tones: &'static [Tone],
    /// Number of panels side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// One pair of axes and what is drawn in it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Panel {
    /// Its letter in the paper, `a`; empty if there is only one panel.
    pub letter: String,
    /// Its heading, after the letter.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// A map of a value over both axes, under everything else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Map>,
    /// The series, the last on top.
    pub series: Vec<Series>,
    /// Lines that are not data: references, the paper's values.
    pub guides: Vec<Guide>,
    /// The text in place of the data if there is nothing to draw: `not run`.
    pub empty: String,
}

impl Panel {
    /// A panel with nothing in it yet.
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
    /// Lower and upper end of an interval at each point, drawn as a band or as whiskers. As long as
    /// `points`, or empty.
    pub band: Vec<(f64, f64)>,
}

impl Series {
    /// A series without intervals.
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
    /// Joined by steps: each value holds until the next.
    Steps,
    /// Drawn as dots.
    Dots,
    /// Bars of this width, centred on x, from zero to y.
    Bars(f64),
    /// The interval at each point, filled from its lower to its upper end: one part of a stack.
    Area,
}

/// What a series is drawn in: a colour and, for print in grey, a position in the lists of dashes and
/// markers. The caller decides what each tone stands for, which is the same in all figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Tone {
    /// The last part of its CSS variable, after `--chart-`, and of its classes: letters, digits, `-`.
    pub name: &'static str,
    /// Red, green and blue on white paper.
    pub rgb: [u8; 3],
    /// Index of its first dash and marker: 0 is a solid line, and discs.
    pub dash: u8,
}

/// A line across a panel that is not data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Guide {
    /// Its name: `the paper: 3.004 ms`.
    pub name: String,
    /// Its position.
    pub at: GuideAt,
}

/// The position of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GuideAt {
    /// Horizontal, at this y.
    Y(f64),
    /// Vertical, at this x.
    X(f64),
    /// Through two points, across the panel.
    Line((f64, f64), (f64, f64)),
}
