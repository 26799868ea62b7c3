//! A tile for each point, with the computed limit as a line across them.

use analysis::sweep::{Limit, Measure, PointRuns};
use chart::{Along, Axis, Map, Mark, Panel, Scale, Series, Tile};
use plan::sweep::Dimension;

use super::{LIMIT, Layout, NOTHING, Subject, TONES, scale};

pub(super) fn panel(
    subject: &Subject<'_>,
    layout: &Layout,
    place: &[usize],
    measure: Measure,
) -> Panel {
    let x = &subject.dimensions[layout.x];
    let y = &subject.dimensions[layout.other.unwrap_or(layout.x)];
    let (columns, rows) = (rising(x), rising(y));
    let tiles = rows.iter().flat_map(|(_, row)| {
        columns.iter().map(move |(_, column)| {
            let point = subject.point(layout, place, *column, *row);
            point.map_or(Tile::None, |point| tile(subject, point, measure))
        })
    });
    let numbers = |levels: &[(f64, usize)]| levels.iter().map(|(number, _)| *number).collect();
    let mut panel = Panel::new(
        Axis::new(x.axis.label(), spacing(&columns)),
        Axis::new(y.axis.label(), spacing(&rows)),
        NOTHING,
    );
    panel.map = Some(Map {
        value: Axis::new(measure.label(), scale(measure)),
        x: Along::Numbers(numbers(&columns)),
        y: Along::Numbers(numbers(&rows)),
        tiles: tiles.collect(),
        hatched: "unstable",
    });
    let points: Vec<(f64, f64)> = rows
        .iter()
        .filter_map(|(number, row)| match subject.limit(layout, place, *row)? {
            Limit::Until(ms) if ms.is_finite() => Some((ms, *number)),
            Limit::Unknown | Limit::None | Limit::Until(_) => None,
        })
        .collect();
    if !points.is_empty() {
        let series = Series::new(LIMIT.to_owned(), Mark::Line, TONES[0], points);
        panel.series.push(series);
    }
    panel
}

/// A point that is stable but has not settled by the end counts as if it settled then, since it takes
/// at least that long.
fn tile(subject: &Subject<'_>, point: &PointRuns, measure: Measure) -> Tile {
    let figure = point.figure(measure);
    match point.is_stable() {
        _ if point.runs == 0 => Tile::None,
        false => Tile::Hatched,
        true if figure.is_finite() => Tile::Value(figure),
        true if measure == Measure::Settling => Tile::Value(subject.sweep.duration_ns as f64 / 1e6),
        true => Tile::None,
    }
}

/// The levels that are numbers, in ascending order, with their places.
fn rising(dimension: &Dimension<'_>) -> Vec<(f64, usize)> {
    let levels = dimension.levels.iter().enumerate();
    let mut numbers: Vec<(f64, usize)> = levels
        .filter_map(|(at, level)| Some((level.number?, at)))
        .collect();
    numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
    numbers
}

/// Logarithmic if the levels are spaced like that, otherwise linear.
fn spacing(levels: &[(f64, usize)]) -> Scale {
    let (Some((first, _)), Some((second, _)), Some((last, _))) =
        (levels.first(), levels.get(1), levels.last())
    else {
        return Scale::Linear;
    };
    // In a geometric series the first step is smaller than the average one; a tenth smaller is enough
    // to recognise it.
    let share = (second - first) / (last - first) * (levels.len() - 1) as f64;
    if *first > 0.0 && share < 0.9 {
        Scale::Log
    } else {
        Scale::Linear
    }
}
