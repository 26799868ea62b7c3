//! What control cost: settling, overshoot, IAE and ISE of each loop, beside a baseline of the same system.

use analysis::Campaign;
use analysis::layout::{Column, number, text};
use text::significant;

use super::{Entry, Table};
use crate::delays::Delays;
use crate::group::Estimate;
use crate::loops::{Loop, all, baseline};

/// A row for each closed loop; `None` if none is complete.
#[must_use]
pub fn table(campaign: &Campaign, delays: &[Delays<'_>]) -> Option<Table> {
    let loops: Vec<Loop<'_>> = all(campaign)
        .into_iter()
        .filter(|one| !one.group.runs.is_empty())
        .collect();
    let first = loops.first()?;
    let differ = |key: fn(&Loop<'_>) -> String| loops.iter().any(|one| key(one) != key(first));
    let names: Vec<Name> = NAMES.into_iter().filter(|(_, key)| differ(*key)).collect();
    let baselines: Vec<Option<&Loop<'_>>> = loops.iter().map(|one| baseline(&loops, one)).collect();
    let rows = loops.iter().zip(&baselines).map(|(one, baseline)| {
        let mut row: Vec<Entry> = names.iter().map(|(_, key)| Entry::text(key(one))).collect();
        row.extend(cost(one));
        if are_some(&baselines) {
            row.extend(beside(one, *baseline));
        }
        row.extend(delay(one, delays));
        row
    });
    let table = Table {
        name: "control".to_owned(),
        title: "What control cost".to_owned(),
        notes: notes(&baselines),
        columns: columns(&names, &baselines),
        rows: rows.collect(),
    };
    Some(table.filled())
}

/// Whether any loop is beside a baseline.
fn are_some(baselines: &[Option<&Loop<'_>>]) -> bool {
    baselines.iter().any(Option::is_some)
}

/// The columns: what names the loops, what they cost, that beside the baselines, and their delays.
fn columns(names: &[Name], baselines: &[Option<&Loop<'_>>]) -> Vec<Column> {
    let names = names.iter().map(|(name, _)| text(name));
    let cost = [
        number("", "holds"),
        number("", "of"),
        number("settling/ms", "median"),
        number("settling/ms", "interval"),
        number("", "overshoot/%"),
        number("", "IAE"),
        number("", "ISE"),
    ];
    let beside = [
        number("× baseline", "settling"),
        number("× baseline", "interval"),
        number("× baseline", "IAE"),
    ];
    let beside = beside.into_iter().filter(|_| are_some(baselines));
    let delay = [
        number("sample's delay/ms", "median"),
        number("sample's delay/ms", "of the link"),
    ];
    names.chain(cost).chain(beside).chain(delay).collect()
}

/// What the figures are, and which loops they are held against.
fn notes(baselines: &[Option<&Loop<'_>>]) -> Vec<String> {
    let mut notes = vec![
        "Medians over the complete runs; an interval holds the median of all such runs with 95 % and needs six of \
         them. Settling is into 2 % of the reference, or the band that the system asks for. IAE, ISE: integrals of \
         the absolute and of the squared error."
            .to_owned(),
        "A sample's delay is from the tick at which y was measured to the tick at which the u that follows from it \
         took effect; the sum of the medians of its parts."
            .to_owned(),
    ];
    let mut named: Vec<String> = Vec::new();
    for one in baselines.iter().flatten() {
        let words = format!("{} on {}, {}", one.who(), one.topology, one.rate);
        if !named.contains(&words) {
            named.push(words);
        }
    }
    if !named.is_empty() {
        notes.push(format!(
            "Baseline: of the same system at the same rate, {}.",
            named.join("; ")
        ));
    }
    notes
}

/// The median delay of a loop's samples, and the link's share of it.
fn delay(one: &Loop<'_>, delays: &[Delays<'_>]) -> [Entry; 2] {
    let here = delays
        .iter()
        .find(|of| one.group.runs.iter().any(|run| of.has(run)));
    let middle = here.and_then(|of| of.parts_ms.map(|parts| parts.iter().sum()));
    [
        Entry::measured(middle, 3),
        Entry::measured(here.and_then(Delays::link_ms), 3),
    ]
}

/// A column that names a loop.
type Name = (&'static str, fn(&Loop<'_>) -> String);

const NAMES: [Name; 5] = [
    ("topology", |one| one.topology.to_owned()),
    ("system", |one| one.system.to_owned()),
    ("client", |one| one.client.to_string()),
    ("setup", |one| one.setup.to_string()),
    ("rate", |one| one.rate.clone()),
];

fn cost(one: &Loop<'_>) -> [Entry; 7] {
    let group = &one.group;
    let settling = group.settling_ms();
    let median = |estimate: Option<Estimate>| {
        Entry::measured(estimate.map(|of| of.value).filter(|x| x.is_finite()), 3)
    };
    [
        Entry::count(one.holding() as u64),
        Entry::count(group.runs.len() as u64),
        median(settling),
        interval(settling),
        // Of a loop that ran away it says nothing.
        if one.holding() > 0 {
            median(group.median(|run| run.summary.overshoot_pct))
        } else {
            Entry::None
        },
        median(group.median(|run| run.summary.iae_s)),
        median(group.median(|run| run.summary.ise_s)),
    ]
}

fn beside(one: &Loop<'_>, baseline: Option<&Loop<'_>>) -> [Entry; 3] {
    let times = |of: fn(&Loop<'_>) -> Option<Estimate>| {
        of(one)?
            .times(of(baseline?)?)
            .filter(|times| times.value.is_finite())
    };
    let settling = times(|of| of.group.settling_ms());
    [
        Entry::measured(settling.map(|times| times.value), 3),
        interval(settling),
        Entry::measured(
            times(|of| of.group.median(|run| run.summary.iae_s)).map(|times| times.value),
            3,
        ),
    ]
}

/// `310 to 344`; empty without an interval.
fn interval(estimate: Option<Estimate>) -> Entry {
    match estimate.filter(Estimate::has_interval) {
        None => Entry::None,
        Some(of) if of.high.is_infinite() => {
            Entry::text(format!("from {} on", significant(of.low, 3)))
        }
        Some(of) => Entry::text(format!(
            "{} to {}",
            significant(of.low, 3),
            significant(of.high, 3)
        )),
    }
}
