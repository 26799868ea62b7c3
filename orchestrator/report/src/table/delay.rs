//! How long messages and samples took, over each link and with each client.

use analysis::layout::{number, text};
use analysis::statistics::percentile;

use super::{Entry, Table};
use crate::delays::{Delays, unstamped};

/// A row for each loop; `None` without a message.
#[must_use]
pub fn table(delays: &[Delays<'_>]) -> Option<Table> {
    if delays.iter().all(|of| of.up_ms.is_empty()) {
        return None;
    }
    let is_closed = delays.iter().any(|of| !of.sample_ms.is_empty());
    let mut columns = vec![text("topology"), text("client"), number("", "messages")];
    columns.extend(
        ["p50", "p90", "p99", "p99.9", "longest"].map(|name| number("round trip/ms", name)),
    );
    columns.extend(["p50", "p99"].map(|name| number("way up/ms", name)));
    columns.extend(["p50", "p99"].map(|name| number("sent late by/ms", name)));
    if is_closed {
        columns
            .extend(["p50", "p99", "longest"].map(|name| number("measurement to effect/ms", name)));
    }
    let rows = delays.iter().map(|of| {
        let at = |sorted: &[f64], share| Entry::measured(percentile(sorted, share), 3);
        let longest = |sorted: &[f64]| Entry::measured(sorted.last().copied(), 3);
        let mut row = vec![
            Entry::text(of.topology),
            Entry::text(of.label.as_str()),
            Entry::count(of.up_ms.len() as u64),
        ];
        row.extend([0.5, 0.9, 0.99, 0.999].map(|share| at(&of.round_trip_ms, share)));
        row.push(longest(&of.round_trip_ms));
        row.extend([0.5, 0.99].map(|share| at(&of.up_ms, share)));
        row.extend([0.5, 0.99].map(|share| at(&of.late_ms, share)));
        if is_closed {
            row.extend([0.5, 0.99].map(|share| at(&of.sample_ms, share)));
            row.push(longest(&of.sample_ms));
        }
        row
    });
    let unstamped = unstamped(delays);
    let mut table = Table {
        name: "delays".to_owned(),
        title: "How long messages took".to_owned(),
        notes: vec![
            "All repeats together. A percentile needs a value beyond it: p99 a hundred values, p99.9 a thousand. \
             Measurement to effect: from the tick at which y was measured to the tick at which the u that follows \
             from it took effect."
                .to_owned(),
        ],
        columns,
        rows: rows.collect(),
    };
    if !unstamped.is_empty() {
        table.notes.push(unstamped.trim_start().to_owned());
    }
    Some(table.filled())
}
