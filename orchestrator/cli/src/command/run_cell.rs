//! `webloop run-cell`: cells of a plan, for `run`, for containers and for job arrays; idempotent.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use backend::{Attempt, Player};
use plan::{Cell, Plan, Verdict};

use crate::argument::{Backend, RunCell};
use crate::earlier::Own;
use crate::exit::{Exit, Failure, Outcome};
use crate::{attach, source, stop};

/// Where job arrays keep the index.
const INDEX_VARIABLES: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// Runs the cells one after another, but for those that are already complete.
pub(crate) fn run(argument: &RunCell) -> Outcome {
    let backend = match argument.backend {
        // First of all: a user namespace can only be entered while there is one thread.
        Backend::Netns => backend::Backend::Netns {
            authority: shaper::become_root(),
            not_before_ns: argument.not_before_ns,
        },
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
    let before = analysis::Run::read(&argument.out, plan, cell);
    if let Some(manifest) = &before.manifest {
        let agents = match backend {
            backend::Backend::Attach(agents) => Some(agents.backend.as_str()),
            backend::Backend::Netns { .. } | backend::Backend::Sim(_) => None,
        };
        let own = Own::new(argument.backend, agents, argument.player);
        own.check(plan, manifest, &before.folder)?;
    }
    match before.verdict() {
        Some(Verdict::Complete) | None if !before.damage.is_empty() => {
            let damage = before.damage.iter().map(ToString::to_string);
            return Err(anyhow!(
                "{}; restore it, or move the cell's folder away to have it run again",
                damage.collect::<Vec<_>>().join("; ")
            )
            .into());
        }
        Some(Verdict::Complete) => return Ok(Exit::Fine),
        _ => {}
    }
    let player = Player::from(argument.player);
    // The plan says how many may run together, the manifest how many did.
    let cell = &Cell {
        together: argument.together,
        ..cell.clone()
    };
    let mut earlier: Vec<String> = Vec::new();
    let manifest = loop {
        let attempt = Attempt {
            started: jiff::Timestamp::now().to_string(),
            earlier: earlier.clone(),
        };
        let manifest =
            backend::run_cell(plan, cell, &argument.out, backend, player, attempt, stop)?;
        if stop.load(Ordering::Relaxed) {
            return Ok(Exit::Interrupted);
        }
        let tries = earlier.len() + 1;
        if manifest.verdict != Verdict::Disturbed || tries >= usize::from(argument.tries) {
            break manifest;
        }
        earlier.push(manifest.reasons.join("; "));
    };
    match manifest.verdict {
        Verdict::Complete => Ok(Exit::Fine),
        Verdict::Unsupported => Err(Failure::unsupported(anyhow!(manifest.reasons.join("; ")))),
        _ => Err(anyhow!(
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
