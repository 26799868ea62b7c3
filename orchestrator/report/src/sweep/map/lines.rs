//! A line for each level of one axis along another.

use analysis::layout::digits;
use analysis::sweep::{Limit, Measure};
use chart::{Along, Axis, Guide, GuideAt, Map, Mark, Panel, Scale, Series, Tone};

use super::layout::{Layout, is_numeric};
use super::{NOTHING, Subject, scale};

/// With more lines one could not tell their computed limits apart; `margins.csv` has them all.
const LIMITS_MAX: usize = 3;

pub(super) fn panel(
    subject: &Subject<'_>,
    layout: &Layout,
    place: &[usize],
    measure: Measure,
) -> Panel {
    let x = &subject.dimensions[layout.x];
    let lines = layout.other.map(|at| &subject.dimensions[at]);
    let mut panel = Panel::new(
        Axis::new(x.axis.label(), Scale::Linear),
        Axis::new(measure.label(), scale(measure)),
        NOTHING,
    );
    if !is_numeric(x) {
        // A map without tiles puts the names where numbers would be.
        panel.map = Some(Map {
            value: Axis::new("", Scale::Linear),
            x: Along::Names(x.levels.iter().map(|level| level.text.clone()).collect()),
            y: Along::Numbers(Vec::new()),
            tiles: Vec::new(),
            hatched: "",
        });
        panel.x.range = Some((-0.5, x.levels.len() as f64 - 0.5));
    }
    let count = lines.map_or(1, |dimension| dimension.levels.len());
    for line in 0..count {
        let name = lines.map_or_else(String::new, |dimension| {
            dimension.axis.title(&dimension.levels[line].text)
        });
        let points = (0..x.levels.len()).filter_map(|at| {
            let figure = subject.point(layout, place, at, line)?.figure(measure);
            let along = if is_numeric(x) {
                x.levels[at].number?
            } else {
                at as f64
            };
            figure.is_finite().then_some((along, figure))
        });
        let tone = Tone::nth(u8::try_from(line).unwrap_or(u8::MAX));
        let series = Series::new(name.clone(), Mark::Line, tone, points.collect());
        panel.series.push(series);
        if let Some(Limit::Until(ms)) = subject.limit(layout, place, line)
            && ms.is_finite()
            && count <= LIMITS_MAX
        {
            panel.guides.push(Guide {
                name: format!("{name}: computed limit, {} ms", digits(Some(ms))),
                at: GuideAt::X(ms),
            });
        }
    }
    panel
}

/// Gives all panels one vertical range, so that their lines can be compared by eye.
pub(super) fn level(panels: &mut [Panel]) {
    let points = panels.iter().flat_map(|panel| &panel.series);
    let ys = points.flat_map(|series| &series.points).map(|(_, y)| *y);
    let (low, high) = ys.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    if low >= high {
        return;
    }
    for panel in panels {
        panel.y.range = Some(match panel.y.scale {
            Scale::Log => (low / ROOM, high * ROOM),
            Scale::Linear => (low.min(0.0), high * ROOM),
        });
    }
}

/// Room around the lines, as a factor.
const ROOM: f64 = 1.1;
