//! A measured table as text, and all values as CSV.

use std::fmt::Write;

use crate::comparison::{Bound, Goal};
use crate::outcome::{MeasuredTable, Series};

/// Columns of the file of values: one row for each repetition's figure.
const COLUMNS: &str = "table,contender,kind,figure,repetition,value\n";

/// Writes the values of all tables.
#[must_use]
pub(crate) fn csv(outcomes: &[MeasuredTable]) -> String {
    let mut text = COLUMNS.to_owned();
    for outcome in outcomes {
        for series in &outcome.series {
            for figure in series.figures() {
                for (time, value) in series.values(figure) {
                    // No name has a quote, and writing to a String does not fail.
                    let _ = writeln!(
                        text,
                        "{},\"{}\",{},{figure},{},{value}",
                        outcome.group,
                        series.contender.name,
                        series.contender.kind.word(),
                        time + 1
                    );
                }
            }
        }
    }
    text
}

/// Writes a table for people: medians, and the first figure as a multiple of the base's with its least and
/// greatest repetition.
#[must_use]
pub(crate) fn text(outcome: &MeasuredTable) -> String {
    let table = outcome.group.table();
    let figures = columns(outcome);
    let mut text = format!("{}: {}\n\n", outcome.group, table.about);
    let _ = write!(text, "{:<9}{:<24}", "", "");
    for figure in &figures {
        let _ = write!(text, "{:>11}", heading(figure));
    }
    let base = table.base.and_then(|base| outcome.of(base));
    let base = base.filter(|base| !base.figures().is_empty());
    if let Some(base) = base {
        let _ = write!(text, "   x {}", base.contender.name);
    }
    text.push('\n');
    for series in &outcome.series {
        line(&mut text, series, &figures, base);
    }
    text.push('\n');
    for goal in table.goals {
        said(&mut text, outcome, goal);
    }
    text
}

/// The figures that any contender has, in order.
fn columns(outcome: &MeasuredTable) -> Vec<&'static str> {
    let mut figures = Vec::new();
    for name in outcome.series.iter().flat_map(Series::figures) {
        if !figures.contains(&name) {
            figures.push(name);
        }
    }
    figures
}

/// A figure's name with its unit behind a stroke: `p50_us` is `p50/us`.
fn heading(figure: &str) -> String {
    match figure {
        "x_real" => "x real".to_owned(),
        "mbit_s" => "Mbit/s".to_owned(),
        "cpu_pct" => "CPU/%".to_owned(),
        "idle_mb" => "idle/MB".to_owned(),
        "message_kb" => "message/kB".to_owned(),
        "read_mb_s" => "read MB/s".to_owned(),
        "write_mb_s" => "write MB/s".to_owned(),
        other => match other.rsplit_once('_') {
            Some((name, unit)) => {
                format!("{name}/{}", unit.replace("us", "µs").replace("pct", "%"))
            }
            None => other.to_owned(),
        },
    }
}

fn line(text: &mut String, series: &Series, figures: &[&str], base: Option<&Series>) {
    let kind = series.contender.kind.word();
    let _ = write!(text, "{kind:<9}{:<24}", series.contender.name);
    if series.is_skipped() {
        let _ = writeln!(text, "   skipped: {}", series.lack().unwrap_or_default());
        return;
    }
    for figure in figures {
        let value = series.median(figure).map_or_else(|| "-".to_owned(), number);
        let _ = write!(text, "{value:>11}");
    }
    if let Some(ratio) = base
        .zip(figures.first())
        .and_then(|(base, figure)| series.ratio(figure, base))
    {
        let _ = write!(
            text,
            "   {} ({} to {})",
            number(ratio.median),
            number(ratio.least),
            number(ratio.most)
        );
    }
    if let Some(lack) = series.lack() {
        let _ = write!(text, "   not each time: {lack}");
    }
    text.push('\n');
}

/// A goal, and what was reached.
fn said(text: &mut String, outcome: &MeasuredTable, goal: &Goal) {
    let (word, bound) = match goal.bound {
        Bound::AtMost(most) => ("at most", most),
        Bound::AtLeast(least) => ("at least", least),
    };
    let than = goal
        .times
        .map_or_else(String::new, |base| format!(" x {base}"));
    let reached = outcome.reached(goal).map_or_else(
        || "not measured".to_owned(),
        |value| {
            let met = if goal.bound.is_met(value) {
                "met"
            } else {
                "short"
            };
            format!("{}, {met}", number(value))
        },
    );
    let _ = writeln!(
        text,
        "goal: {}, {} {word} {}{than}: {reached}",
        goal.contender,
        heading(goal.figure),
        number(bound)
    );
}

/// A number with three digits, or all before the point.
fn number(value: f64) -> String {
    let decimals = match value.abs() {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        v if v >= 0.1 => 3,
        _ => 4,
    };
    format!("{value:.decimals$}")
}
