//! The ranges of a panel's axes, from its data, its guides or its map.

use crate::axis::{Axis, Scale};
use crate::chart::{GuideAt, Mark, Panel};
use crate::grid;
use crate::map::Along;
use crate::span::{Span, drawable};

/// The ranges of both axes of a panel; `None` if there is nothing to draw.
pub(crate) fn of(panel: &Panel) -> Option<(Span, Span)> {
    if let Some(map) = grid::map(panel) {
        return Some((across(&panel.x, &map.x)?, across(&panel.y, &map.y)?));
    }
    let x_values = panel.series.iter().flat_map(|series| {
        let half = match series.mark {
            Mark::Bars(width) => width / 2.0,
            Mark::Line | Mark::Steps | Mark::Dots | Mark::Area => 0.0,
        };
        series
            .points
            .iter()
            .filter(|point| drawable(point.1, panel.y.scale))
            .flat_map(move |point| [point.0 - half, point.0 + half])
    });
    let x_guides = panel.guides.iter().filter_map(|guide| match guide.at {
        GuideAt::X(x) => Some(x),
        GuideAt::Y(_) | GuideAt::Line(..) => None,
    });
    let x = along(&panel.x, x_values, x_guides, 0.02)?;

    let seen = |value: f64| {
        x.fraction(value)
            .is_some_and(|at| (0.0..=1.0).contains(&at))
    };
    let y_values = panel.series.iter().flat_map(|series| {
        let bands = series.band.len() == series.points.len();
        let floor = match series.mark {
            Mark::Bars(_) => Some(0.0),
            Mark::Line | Mark::Steps | Mark::Dots | Mark::Area => None,
        };
        series
            .points
            .iter()
            .enumerate()
            .filter(move |(_, point)| seen(point.0))
            .flat_map(move |(index, point)| {
                let band = bands.then(|| series.band.get(index)).flatten();
                [Some(point.1), band.map(|b| b.0), band.map(|b| b.1), floor]
            })
            .flatten()
    });
    let y_guides = panel.guides.iter().filter_map(|guide| match guide.at {
        GuideAt::Y(y) => Some(y),
        GuideAt::X(_) | GuideAt::Line(..) => None,
    });
    let y = along(&panel.y, y_values, y_guides, 0.05)?;
    Some((x, y))
}

/// The range that was asked for if it can be drawn, else that of the data and the guides. `None`
/// without data; y has none if all data are outside the range of x.
fn along(
    axis: &Axis,
    values: impl Iterator<Item = f64>,
    guides: impl Iterator<Item = f64>,
    margin: f64,
) -> Option<Span> {
    let scale = axis.scale;
    let least_most = |(lo, hi): (f64, f64), v: f64| (lo.min(v), hi.max(v));
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let data = values
        .filter(|v| drawable(*v, scale))
        .fold(none, least_most);
    if data.0 > data.1 {
        return None;
    }
    if let Some(asked) = Span::asked(axis) {
        return Some(asked);
    }
    let (lo, hi) = guides
        .filter(|v| drawable(*v, scale))
        .fold(data, least_most);
    Some(Span { lo, hi, scale }.widened().with_margin(margin))
}

/// The range of a map's columns or rows, or the one that was asked for; `None` if there are no
/// columns or rows.
fn across(axis: &Axis, along: &Along) -> Option<Span> {
    let (asked, scale) = match along {
        Along::Numbers(_) => (Span::asked(axis), axis.scale),
        Along::Names(_) => (None, Scale::Linear),
    };
    let (lo, hi) = grid::ends(along, scale)?;
    asked.or_else(|| Some(Span { lo, hi, scale }.widened()))
}
