//! Figures of a sweep: a map if two axes are long, lines if they are short.
//!
//! `layout` decides from the axes alone which axis is drawn where; `tiles` and `lines` draw. Each
//! remaining level has its own panel.

mod layout;
mod lines;
mod tiles;

use std::sync::LazyLock;

use analysis::layout::digits;
use analysis::sweep::{Border, Limit, Measure, PointRuns};
use chart::{Chart, Panel, Scale, Tone};
use plan::Client;
use plan::sweep::{Axis, Dimension, Sweep};

use crate::tone::{OTHER_TONE, PLANT_TONE, tone_of};

use layout::{Form, Layout};

/// The tones that a page may set, the same as in a report's figures; the computed limit has the first.
static TONES: LazyLock<Vec<Tone>> = LazyLock::new(|| {
    let clients = Client::ALL.into_iter().map(tone_of);
    clients.chain([PLANT_TONE, OTHER_TONE]).collect()
});

/// Most panels in one figure.
const PANELS_MAX: usize = 12;
/// The text of a panel that has nothing to show.
const NOTHING: &str = "nothing settled";
/// The name of the computed limit.
const LIMIT: &str = "longest stable round trip, computed";

/// The figures of a sweep, one for each measure; none if nothing is varied.
#[must_use]
pub fn maps(sweep: &Sweep, points: &[PointRuns], borders: &[Border]) -> Vec<Chart> {
    let subject = Subject {
        sweep,
        dimensions: sweep.grid.dimensions(),
        points,
        borders,
    };
    let Some(layout) = Layout::of(&subject.dimensions) else {
        return Vec::new();
    };
    Measure::ALL
        .map(|measure| subject.chart(&layout, measure))
        .into()
}

/// The data of a drawing.
struct Subject<'a> {
    sweep: &'a Sweep,
    dimensions: Vec<Dimension<'a>>,
    points: &'a [PointRuns],
    borders: &'a [Border],
}

impl Subject<'_> {
    fn chart(&self, layout: &Layout, measure: Measure) -> Chart {
        let places = self.panels(layout);
        let drawn = places.len().min(PANELS_MAX);
        let mut panels: Vec<Panel> = places
            .iter()
            .take(drawn)
            .enumerate()
            .map(|(number, place)| {
                let mut panel = match layout.form {
                    Form::Tiles => tiles::panel(self, layout, place, measure),
                    Form::Lines => lines::panel(self, layout, place, measure),
                };
                if drawn > 1 {
                    panel.letter = letter(number);
                }
                panel.title = self.heading(layout, place);
                panel
            })
            .collect();
        if layout.form == Form::Lines {
            lines::level(&mut panels);
        }
        Chart {
            name: measure.word().to_owned(),
            title: self.title(measure),
            about: self.about(measure),
            source: self.source(layout, measure, places.len(), drawn),
            tones: &TONES,
            columns: drawn.clamp(1, 2),
            panels,
        }
    }

    /// The place of each panel, at the first level of the axes drawn in it.
    fn panels(&self, layout: &Layout) -> Vec<Vec<usize>> {
        let mut places = vec![vec![0; self.dimensions.len()]];
        for at in &layout.panels {
            let levels = self.dimensions[*at].levels.len();
            let with = |place: &Vec<usize>, level| {
                let mut place = place.clone();
                place[*at] = level;
                place
            };
            places = places
                .iter()
                .flat_map(|place| (0..levels).map(move |level| with(place, level)))
                .collect();
        }
        places
    }

    /// The levels that distinguish a panel from the others.
    fn heading(&self, layout: &Layout, place: &[usize]) -> String {
        let words = layout.panels.iter().map(|at| {
            let dimension = &self.dimensions[*at];
            dimension.axis.title(&dimension.levels[place[*at]].text)
        });
        words.collect::<Vec<_>>().join(", ")
    }

    fn title(&self, measure: Measure) -> String {
        let what = match measure {
            Measure::Settling => "Settling of the unit step",
            Measure::Overshoot => "Overshoot of the unit step",
            Measure::Iae => "Absolute error of the unit step, integrated",
            Measure::Cost => "Quadratic cost of the unit step",
        };
        format!("{what}: sweep {}", self.sweep.name)
    }

    /// The figure's text alternative.
    fn about(&self, measure: Measure) -> String {
        let stable = self.points.iter().filter(|point| point.is_stable()).count();
        let figures = self.points.iter().map(|point| point.figure(measure));
        let finite = figures.filter(|figure| figure.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let mut about = format!("Of {} points {stable} are stable.", self.points.len(),);
        if low <= high {
            let word = |x| digits(Some(x));
            about += &format!(
                " {} goes from {} to {}.",
                measure.label(),
                word(low),
                word(high)
            );
        }
        about
    }

    /// The levels that were fixed, and how the sweep was run.
    fn source(&self, layout: &Layout, measure: Measure, panels: usize, drawn: usize) -> String {
        let still = self
            .dimensions
            .iter()
            .filter(|dimension| dimension.levels.len() == 1)
            .filter(|dimension| !is_idle(dimension))
            .map(|dimension| dimension.axis.title(&dimension.levels[0].text));
        let repeats = match self.sweep.repeats {
            1 => String::new(),
            repeats => format!("medians of {repeats} runs; "),
        };
        let mut source = format!(
            "{repeats}virtual time, {} s a run, seed {}; {}",
            self.sweep.duration_ns as f64 / 1e9,
            self.sweep.seed,
            still.collect::<Vec<_>>().join(", ")
        );
        if measure == Measure::Cost {
            source += &format!(", rho = {}", self.sweep.rho);
        }
        let is_missing = |point: &PointRuns| point.figure(measure).is_infinite();
        if layout.form == Form::Lines && self.points.iter().any(is_missing) {
            source += match measure {
                Measure::Settling => "; no line where half of the runs did not settle",
                _ => "; no line where half of the runs were unstable",
            };
        }
        if drawn < panels {
            let axes = layout
                .panels
                .iter()
                .map(|at| self.dimensions[*at].axis.word());
            source += &format!(
                "; the first {drawn} of {panels} panels: --fix {}=... chooses others",
                axes.collect::<Vec<_>>().join("=... or ")
            );
        }
        source
    }

    /// The point at these levels of x and of the other axis, at the panel's place.
    fn point(
        &self,
        layout: &Layout,
        place: &[usize],
        x: usize,
        other: usize,
    ) -> Option<&PointRuns> {
        let mut there = place.to_vec();
        there[layout.x] = x;
        if let Some(at) = layout.other {
            there[at] = other;
        }
        self.points.get(self.sweep.grid.number(&there))
    }

    /// The computed limit, if round trips lie along x; otherwise `None`.
    fn limit(&self, layout: &Layout, place: &[usize], other: usize) -> Option<Limit> {
        let mut there = place.to_vec();
        if let Some(at) = layout.other {
            there[at] = other;
        }
        let is_there = |border: &&Border| {
            let same = border.place.iter().zip(&there).enumerate();
            same.filter(|(at, _)| *at != layout.x)
                .all(|(_, (a, b))| a == b)
        };
        (self.dimensions[layout.x].axis == Axis::Rtt)
            .then(|| self.borders.iter().find(is_there))
            .flatten()
            .map(|border| border.limit)
    }
}

/// Whether an axis has no effect: no jitter, no loss, no rate limit.
fn is_idle(dimension: &Dimension<'_>) -> bool {
    let level = dimension.levels.first().map_or("", |level| &level.text);
    matches!(
        (dimension.axis, level),
        (Axis::Jitter | Axis::Loss, "0") | (Axis::Rate, "none")
    )
}

/// The scale of a measure: logarithmic if its values differ by factors, linear for shares.
fn scale(measure: Measure) -> Scale {
    match measure {
        Measure::Overshoot => Scale::Linear,
        Measure::Settling | Measure::Iae | Measure::Cost => Scale::Log,
    }
}

/// a, b, c, ...
fn letter(number: usize) -> String {
    let letters = 'a'..='z';
    letters.skip(number).take(1).collect()
}
