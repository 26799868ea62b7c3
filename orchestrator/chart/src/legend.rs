//! Places each name once: in the legend of the chart, or in that of its panel.
//!
//! A name is in the chart's legend if nothing else in the chart looks like it. Names that share a
//! look, such as a client's slope in each of six panels, are above their own panels.

use crate::chart::{Chart, Panel, Series};
use crate::layout::{self, LEADING, LEGEND_SIZE};
use crate::look::{Kind, Look, Looks};
use crate::scene::{Layer, Place, Shape, Text};
use crate::text;

/// Width of the sample beside a name.
const SAMPLE: f64 = 16.0;

/// Gap between the sample and the name.
const SPACE: f64 = 4.0;

/// Gap between one name and the next sample.
const GAP: f64 = 12.0;

/// Distance from one row to the next.
const ROW: f64 = LEGEND_SIZE * LEADING + 1.0;

/// A name with its sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) look: Look,
    /// Whether its sample has a band behind it.
    pub(crate) band: bool,
}

/// The names of a panel's series, each once.
fn entries(panel: &Panel, looks: &Looks) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for series in panel.series.iter().filter(|series| !series.name.is_empty()) {
        let look = looks.series(series);
        let band = has_band(series);
        match entries
            .iter_mut()
            .find(|entry| entry.look == look && entry.name == series.name)
        {
            Some(entry) => entry.band |= band,
            None => entries.push(Entry {
                name: series.name.clone(),
                look,
                band,
            }),
        }
    }
    entries
}

fn has_band(series: &Series) -> bool {
    !series.band.is_empty() && series.band.len() == series.points.len()
}

/// The chart's legend, and that of each panel. `beside` has the guides of each panel whose names
/// found no room in it.
pub(crate) fn split(
    chart: &Chart,
    looks: &Looks,
    beside: &[Vec<Entry>],
) -> (Vec<Entry>, Vec<Vec<Entry>>) {
    let of_panels: Vec<Vec<Entry>> = chart
        .panels
        .iter()
        .enumerate()
        .map(|(index, panel)| {
            let mut all = entries(panel, looks);
            all.extend(beside.get(index).cloned().unwrap_or_default());
            all
        })
        .collect();
    let all: Vec<&Entry> = of_panels.iter().flatten().collect();
    let alone = |entry: &Entry| {
        all.iter()
            .all(|other| other.look != entry.look || other.name == entry.name)
    };
    let mut shared: Vec<Entry> = Vec::new();
    for entry in all.iter().filter(|entry| alone(entry)) {
        match shared.iter_mut().find(|known| known.look == entry.look) {
            Some(known) => known.band |= entry.band,
            None => shared.push((*entry).clone()),
        }
    }
    let own = of_panels
        .iter()
        .map(|panel| {
            panel
                .iter()
                .filter(|entry| !alone(entry))
                .cloned()
                .collect()
        })
        .collect();
    (shared, own)
}

fn widths(entries: &[Entry], room: f64) -> Vec<f64> {
    entries
        .iter()
        .map(|entry| SAMPLE + SPACE + text::width(&entry.name, size(entry, room), false))
        .collect()
}

/// Font size of a name; smaller for a long one, so that it stays on the page.
fn size(entry: &Entry, room: f64) -> f64 {
    layout::fitting(&entry.name, LEGEND_SIZE, room - SAMPLE - SPACE)
}

/// Height of a legend of this width.
pub(crate) fn height(entries: &[Entry], room: f64) -> f64 {
    layout::flow(&widths(entries, room), GAP, room).1 as f64 * ROW
}

/// Draws a legend from its top left corner.
pub(crate) fn draw(entries: &[Entry], at: Place, room: f64) -> Layer {
    let (places, _) = layout::flow(&widths(entries, room), GAP, room);
    let mut shapes = Vec::new();
    for (entry, (x, row)) in entries.iter().zip(places) {
        let left = at.0 + x;
        let base = at.1 + row as f64 * ROW + LEGEND_SIZE;
        sample(entry, (left, base - LEGEND_SIZE * 0.34), &mut shapes);
        shapes.push(Shape::Text(Text::at(
            (left + SAMPLE + SPACE, base),
            size(entry, room),
            &entry.name,
        )));
    }
    Layer { name: None, shapes }
}

fn sample(entry: &Entry, middle: Place, shapes: &mut Vec<Shape>) {
    let (left, y) = middle;
    let rectangle = |half: f64| {
        vec![
            (left, y - half),
            (left + SAMPLE, y - half),
            (left + SAMPLE, y + half),
            (left, y + half),
        ]
    };
    let colour = entry.look.colour;
    if entry.band && entry.look.kind == Kind::Line {
        shapes.push(Shape::Areas {
            areas: vec![rectangle(3.0)],
            colour,
            opacity: 20,
        });
    }
    shapes.push(match entry.look.kind {
        Kind::Line | Kind::Guide => Shape::Lines {
            lines: vec![vec![(left, y), (left + SAMPLE, y)]],
            stroke: entry.look.stroke(if entry.look.kind == Kind::Guide {
                0.8
            } else {
                1.2
            }),
        },
        Kind::Dots => Shape::Markers {
            places: vec![(left + SAMPLE / 2.0, y)],
            shape: entry.look.marker(),
            size: 4.0,
            colour,
            opacity: 100,
        },
        Kind::Bars => Shape::Areas {
            areas: vec![rectangle(3.0)],
            colour,
            opacity: 70,
        },
    });
}
