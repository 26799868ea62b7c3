//! A sweep as a table and a few sentences.

use crate::layout::{Column, align, digits, number, text};

use super::border::{Border, Limit};
use super::finding::findings;
use super::runs::{Measure, PointRuns};
use plan::sweep::{Axis, Sweep};

/// Nobody reads a longer table; the file has all rows.
const ROWS_MAX: usize = 60;

/// What people want to know about a sweep, as text.
#[must_use]
pub fn summary(sweep: &Sweep, points: &[PointRuns], borders: &[Border]) -> String {
    let mut paragraphs = Vec::new();
    if points.len() <= ROWS_MAX {
        paragraphs.push(table(sweep, points));
    }
    if (1..=ROWS_MAX).contains(&borders.len()) {
        paragraphs.push(longest(sweep, borders));
    }
    let mut sentences = vec![stable(points)];
    sentences.extend(soonest(sweep, points));
    sentences.extend(agreement(borders));
    sentences.extend(findings(sweep, points).iter().map(ToString::to_string));
    paragraphs.push(sentences.join("\n") + "\n");
    paragraphs.join("\n")
}

/// The axes with several levels, and their positions.
fn varied(sweep: &Sweep) -> Vec<(usize, Axis)> {
    let dimensions = sweep.grid.dimensions().into_iter().enumerate();
    let several = dimensions.filter(|(_, dimension)| dimension.levels.len() > 1);
    several
        .map(|(at, dimension)| (at, dimension.axis))
        .collect()
}

fn columns(axes: &[(usize, Axis)]) -> Vec<Column> {
    let column = |axis: Axis| match axis {
        Axis::Topology | Axis::Client | Axis::System => text(axis.heading()),
        _ => number("", axis.heading()),
    };
    axes.iter().map(|(_, axis)| column(*axis)).collect()
}

/// The levels of these axes at a place.
fn entries(sweep: &Sweep, axes: &[(usize, Axis)], place: &[usize]) -> Vec<String> {
    let dimensions = sweep.grid.dimensions();
    let level = |at: usize| dimensions[at].levels[place[at]].text.clone();
    axes.iter().map(|(at, _)| level(*at)).collect()
}

/// A row for each point.
fn table(sweep: &Sweep, points: &[PointRuns]) -> String {
    let axes = varied(sweep);
    let mut head = columns(&axes);
    head.extend([
        number("", "stable"),
        number("", "settling/ms"),
        number("", "overshoot/%"),
        number("", "IAE/s"),
        number("", "cost/s"),
    ]);
    let rows: Vec<Vec<String>> = points
        .iter()
        .enumerate()
        .map(|(number, point)| {
            let mut row = entries(sweep, &axes, &sweep.grid.place(number));
            row.push(format!("{}/{}", point.stable, point.runs));
            row.extend(Measure::ALL.map(|measure| digits(Some(point.figure(measure)))));
            row
        })
        .collect();
    align(&head, &rows)
}

/// A row for each border.
fn longest(sweep: &Sweep, borders: &[Border]) -> String {
    let mut axes = varied(sweep);
    axes.retain(|(_, axis)| *axis != Axis::Rtt);
    let mut head = columns(&axes);
    head.extend([
        number("longest stable round trip/ms", "found"),
        number("longest stable round trip/ms", "computed"),
        text("within one sample"),
    ]);
    let rows: Vec<Vec<String>> = borders
        .iter()
        .map(|border| {
            let mut row = entries(sweep, &axes, &border.place);
            row.push(match (border.found_ms, border.lost_ms) {
                (None, _) => "none".to_owned(),
                (Some(found_ms), None) => format!("all to {found_ms}"),
                (Some(found_ms), Some(_)) => found_ms.to_string(),
            });
            row.push(match border.limit {
                Limit::Unknown => "-".to_owned(),
                Limit::None => "none".to_owned(),
                Limit::Until(ms) if ms.is_finite() => digits(Some(ms)),
                Limit::Until(_) => "every".to_owned(),
            });
            row.push(match border.agrees() {
                None => "-".to_owned(),
                Some(true) => "yes".to_owned(),
                Some(false) => "no".to_owned(),
            });
            row
        })
        .collect();
    align(&head, &rows)
}

fn stable(points: &[PointRuns]) -> String {
    let stable = points.iter().filter(|point| point.is_stable()).count();
    format!("{stable} of {} points are stable.", points.len())
}

/// The point that settles first, if points differ.
fn soonest(sweep: &Sweep, points: &[PointRuns]) -> Option<String> {
    let axes = varied(sweep);
    let settling = |point: &PointRuns| point.figure(Measure::Settling);
    let all = points.iter().enumerate();
    let (number, point) = all.min_by(|a, b| settling(a.1).total_cmp(&settling(b.1)))?;
    let place = sweep.grid.place(number);
    let levels = entries(sweep, &axes, &place);
    let at = axes
        .iter()
        .zip(&levels)
        .map(|((_, axis), text)| axis.title(text));
    (settling(point).is_finite() && !axes.is_empty()).then(|| {
        format!(
            "It settles soonest, in {} ms, at {}.",
            digits(Some(settling(point))),
            at.collect::<Vec<_>>().join(", ")
        )
    })
}

/// Whether the sweep's borders agree with analysis.
fn agreement(borders: &[Border]) -> Option<String> {
    let compared: Vec<&Border> = borders.iter().filter(|b| b.off_ms().is_some()).collect();
    if compared.is_empty() {
        return None;
    }
    let agree = compared.iter().filter(|b| b.agrees() == Some(true)).count();
    let offs = compared.iter().filter_map(|border| border.off_ms());
    Some(format!(
        "The longest stable round trip is within one sample of the computed one in {agree} of {} \
         cases; the farthest is {} ms off.",
        compared.len(),
        digits(Some(offs.fold(0.0, f64::max)))
    ))
}
