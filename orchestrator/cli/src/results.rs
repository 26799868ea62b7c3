//! A results folder read back: each cell's manifest and metrics as one row.

use std::path::Path;

use analysis::{CellFacts, Metrics, Summary};
use anyhow::anyhow;
use plan::{Cell, Plan, Verdict};

/// What is in a results folder, of the cells of its plan.
pub(crate) struct Results {
    /// One row for each cell that has been run or was asked for, in the plan's order.
    pub(crate) rows: Vec<Summary>,
    /// How many cells the plan has besides: nobody has run them here, which is no failure.
    absent: usize,
}

impl Results {
    /// Reads the folder; `asked` cells get a row even if they have not been run.
    ///
    /// # Errors
    /// When a manifest or a row file is damaged; names file and line.
    pub(crate) fn read(
        folder: &Path,
        plan: &Plan,
        asked: impl Fn(&Cell) -> bool,
    ) -> anyhow::Result<Results> {
        let mut rows = Vec::new();
        for cell in &plan.cells {
            let row = row(folder, plan, cell)?;
            if row.verdict.is_some() || asked(cell) {
                rows.push(row);
            }
        }
        let absent = plan.cells.len() - rows.len();
        Ok(Results { rows, absent })
    }

    /// The table of the cells and, where some were repeated, that of their medians.
    pub(crate) fn table(&self) -> String {
        let mut table = analysis::table::render(&self.rows);
        if let Some(medians) = analysis::repeats::render(&self.rows) {
            table += &format!("\n{medians}");
        }
        if self.absent > 0 {
            let all = self.rows.len() + self.absent;
            table += &format!(
                "\n{} of the plan's {all} cells have not been run here.\n",
                self.absent
            );
        }
        table
    }

    /// Every figure of the table and more, for programs.
    pub(crate) fn csv(&self) -> String {
        Summary::to_csv(&self.rows)
    }
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
    let metrics = match verdict.is_some_and(has_rows) {
        true => Some(Metrics::read(
            &backend::cell_folder(folder, cell),
            &CellFacts::from(cell),
        )?),
        false => None,
    };
    Ok(Summary::new(cell, verdict, asked_ms, metrics.as_ref()))
}

/// Whether a run that ended so left its rows: one that did not come to its end may have none at all.
pub(crate) fn has_rows(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Complete | Verdict::Invalid)
}
