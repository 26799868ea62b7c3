//! `webloop run-cell`: cells of a plan, for `run`, for containers and for job arrays; idempotent.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use backend::Player;
use plan::{Cell, Plan, Verdict};

use crate::argument::{Backend, RunCell};
use crate::exit::{Exit, Failure, Outcome};
use crate::{attach, source, stop};

/// Where job arrays keep the index.
const INDEX_VARIABLES: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// Runs the cells one after another, but for those that are already complete.
pub(crate) fn run(argument: &RunCell) -> Outcome {
    let backend = match argument.backend {
        // First of all: a user namespace can only be entered while there is one thread.
        Backend::Netns => backend::Backend::Netns(shaper::become_root()),
        Backend::Attach => backend::Backend::Attach(attach::agents()?),
        Backend::Sim => {
            backend::Backend::Sim(Box::new(source::timings(argument.timing.as_deref())?))
        }
        Backend::Compose => {
            return Err(Failure::usage(anyhow!(
                "run-cell runs no containers; use `webloop run --backend compose --only ..`"
            )));
        }
    };
    let plan = source::plan(&argument.plan)?;
    let indices = match argument.index.as_slice() {
        [] => vec![index_of_the_job()?],
        given => given.to_vec(),
    };
    let cells = indices
        .into_iter()
        .map(|index| cell(&plan, index))
        .collect::<Result<Vec<_>, _>>()?;
    let stop = stop::told_to_end()?;
    if argument.backend == Backend::Attach {
        stop::give_up_soon_after(&stop)?;
    }
    let mut worst = Ok(Exit::Fine);
    for cell in cells {
        if stop.load(Ordering::Relaxed) {
            return Ok(Exit::Interrupted);
        }
        let outcome = run_one(&plan, cell, argument, &backend, &stop);
        // The first that goes wrong is told; the others are in their manifests.
        if matches!(worst, Ok(Exit::Fine)) {
            worst = outcome;
        }
    }
    worst
}

fn cell(plan: &Plan, index: usize) -> Result<&Cell, Failure> {
    plan.cell(index).ok_or_else(|| {
        let cells = match plan.cells.as_slice() {
            [] => "it has none".to_owned(),
            [only] => format!("its only one is {}", only.index),
            [first, .., last] => format!("they go from {} to {}", first.index, last.index),
        };
        Failure::usage(anyhow!("the plan has no cell {index}; {cells}"))
    })
}

fn run_one(
    plan: &Plan,
    cell: &Cell,
    argument: &RunCell,
    backend: &backend::Backend,
    stop: &AtomicBool,
) -> Outcome {
    let before = backend::manifest(&argument.out, cell).map_err(|problem| anyhow!(problem))?;
    if before.is_some_and(|manifest| {
        manifest.verdict == Verdict::Complete && manifest.cell.is_same(cell)
    }) {
        return Ok(Exit::Fine);
    }
    let started = jiff::Timestamp::now().to_string();
    let player = Player::from(argument.player);
    let manifest = backend::run_cell(plan, cell, &argument.out, backend, player, started, stop)?;
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
