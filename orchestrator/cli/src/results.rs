//! A results folder read back: each cell's manifest and metrics as one row.

use std::path::Path;

use analysis::{CellFacts, Metrics, Summary};
use anyhow::anyhow;
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
        // Loopback is what it is: nothing is asked of it.
        .filter(|profile| !profile.is_loopback())
        .and_then(|profile| profile.asked())
        .map(|asked| asked.rtt_avg_ms);
    // A run that did not come to its end may have left no rows at all.
    let metrics = match verdict {
        Some(Verdict::Complete | Verdict::Invalid) => Some(Metrics::read(
            &backend::cell_folder(folder, cell),
            &CellFacts::from(cell),
        )?),
        _ => None,
    };
    Ok(Summary::new(cell, verdict, asked_ms, metrics.as_ref()))
}

/// The table of the cells and, where some were repeated, that of their medians.
pub(crate) fn tables(rows: &[Summary]) -> String {
    let medians =
        analysis::repeats::render(rows).map_or(String::new(), |medians| format!("\n{medians}"));
    analysis::table::render(rows) + &medians
}
