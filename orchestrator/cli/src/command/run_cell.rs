//! `webloop run-cell`: one cell of a plan, for `run` and for job arrays; idempotent.

use std::sync::atomic::Ordering;

use anyhow::anyhow;
use plan::Verdict;

use crate::argument::RunCell;
use crate::exit::{Exit, Failure, Outcome};
use crate::{source, stop};

/// Where job arrays keep the index.
const INDEX_VARIABLES: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// Runs the cell, unless it is already complete.
pub(crate) fn run(argument: &RunCell) -> Outcome {
    // First of all: a user namespace can only be entered while there is one thread.
    let authority = shaper::become_root();
    let plan = source::plan(&argument.plan)?;
    let index = argument.index.map_or_else(index_of_the_job, Ok)?;
    let cell = plan.cell(index).ok_or_else(|| {
        let cells = match plan.cells.as_slice() {
            [] => "it has none".to_owned(),
            [only] => format!("its only one is {}", only.index),
            [first, .., last] => format!("they go from {} to {}", first.index, last.index),
        };
        Failure::usage(anyhow!("the plan has no cell {index}; {cells}"))
    })?;
    let before = backend::manifest(&argument.out, cell).map_err(|problem| anyhow!(problem))?;
    if before
        .is_some_and(|manifest| manifest.verdict == Verdict::Complete && manifest.cell == *cell)
    {
        return Ok(Exit::Fine);
    }
    let stop = stop::told_to_end()?;
    let started = jiff::Timestamp::now().to_string();
    let manifest = backend::run_cell(&plan, cell, &argument.out, authority, started, &stop)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(Exit::Interrupted);
    }
    match manifest.verdict {
        Verdict::Complete => Ok(Exit::Fine),
        Verdict::Unsupported => Err(Failure::unsupported(anyhow!(manifest.reasons.join("; ")))),
        Verdict::Invalid | Verdict::Failed => Err(anyhow!(
            "{} is {}: {}",
            cell.id,
            manifest.verdict,
            manifest.reasons.join("; ")
        )
        .into()),
    }
}

fn index_of_the_job() -> Result<usize, Failure> {
    INDEX_VARIABLES
        .iter()
        .find_map(|name| std::env::var(name).ok()?.parse().ok())
        .ok_or_else(|| {
            Failure::usage(anyhow!(
                "which cell? give --index, or set {}",
                INDEX_VARIABLES.join(" or ")
            ))
        })
}
