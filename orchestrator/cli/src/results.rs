//! A results folder read back: each cell's manifest and metrics as one row.

use std::path::Path;

use analysis::{CellFacts, Metrics, Summary};
use anyhow::{Context, anyhow};
use plan::{Cell, Plan, Verdict};

/// One row for each cell of the plan, run or not, in the plan's order.
///
/// # Errors
/// When a manifest or a row file is damaged; names file and line.
pub(crate) fn rows(folder: &Path, plan: &Plan) -> anyhow::Result<Vec<Summary>> {
    plan.cells
        .iter()
        .map(|cell| row(folder, plan, cell))
        .collect()
}

fn row(folder: &Path, plan: &Plan, cell: &Cell) -> anyhow::Result<Summary> {
    let manifest = backend::manifest(folder, cell).map_err(|problem| anyhow!(problem))?;
    let verdict = manifest.map(|manifest| manifest.verdict);
    let asked_ms = plan
        .profiles
        .get(&cell.topology)
        .and_then(|text| text.profile(&cell.topology).ok())
        .and_then(|profile| profile.asked())
        .map(|asked| asked.rtt_avg_ms);
    // A run that did not come to its end may have left no rows at all.
    let metrics = match verdict {
        Some(Verdict::Complete | Verdict::Invalid) => {
            let facts = CellFacts {
                h_ns: cell.settings.h.ns(),
                mode: cell.settings.mode,
                r: cell.settings.r,
            };
            Some(Metrics::read(&backend::cell_folder(folder, cell), &facts)?)
        }
        _ => None,
    };
    Ok(Summary::new(cell, verdict, asked_ms, metrics.as_ref()))
}

/// The rows as CSV, with units in the header.
pub(crate) fn csv(rows: &[Summary]) -> anyhow::Result<String> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.serialize(row)?;
    }
    let bytes = csv.into_inner().context("cannot write a table in memory")?;
    Ok(String::from_utf8(bytes)?)
}
