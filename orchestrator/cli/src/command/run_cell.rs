//! `webloop run-cell`: runs cells of a plan, for `run`, containers and job arrays; idempotent.

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, anyhow};
use backend::{Agents, Awake, Virtual};
use campaign::{CampaignFolder, CellRun, Ended, Own, Turn, attach, run_cell};
use containers::Token;
use plan::{Cell, Plan, Verdict, file_name};

use crate::argument::{Backend, Player, Run, RunCell, word};
use crate::exit::{Exit, Failure, Outcome};
use crate::{source, stop};

/// The variables in which job arrays keep the index.
const INDEX_VARIABLES: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// Runs the cells one after another, except those that are already complete.
pub(crate) fn run(argument: &RunCell) -> Outcome {
    let backend = match argument.backend {
        // First of all: a user namespace can only be entered while there is one thread.
        Backend::Netns => backend::Backend::Netns {
            authority: shaper::become_root(),
            not_before_ns: argument.not_before_ns,
            awake: awake(argument.awake, argument.backend)?,
        },
        Backend::Attach => backend::Backend::Attach(attach::agents()?),
        Backend::Sim => {
            let timings = source::timings(argument.timing.as_deref())?;
            backend::Backend::Sim(Box::new(Virtual::new(timings)))
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
    // `run` starts this program with the plan that is in the folder already.
    if argument.plan != argument.out.join(file_name::PLAN) {
        CampaignFolder::leave_plan(&plan, &argument.out)?;
    }
    let stop = stop::told_to_end()?;
    if argument.backend == Backend::Attach {
        stop::give_up_soon_after(&stop)?;
    }
    let agents = match &backend {
        backend::Backend::Attach(agents) => Some(agents),
        backend::Backend::Netns { .. } | backend::Backend::Sim(_) => None,
    };
    let how = CellRun {
        campaign: &argument.out,
        backend: &backend,
        player: argument.player.into(),
        own: own(argument.backend, agents, argument.player),
        tries: argument.tries,
        together: argument.together,
    };
    let mut worst = Ok(Exit::Fine);
    for cell in cells {
        if stop.load(Ordering::Relaxed) {
            return Ok(Exit::Interrupted);
        }
        let outcome = run_one(&plan, cell, &how, &stop);
        // Report the first failure; the others are in their manifests.
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

fn run_one(plan: &Plan, cell: &Cell, how: &CellRun<'_>, stop: &AtomicBool) -> Outcome {
    let manifest = match run_cell(plan, cell, how, stop)? {
        Ended::Before => return Ok(Exit::Fine),
        Ended::Interrupted => return Ok(Exit::Interrupted),
        Ended::Now(manifest) => manifest,
    };
    let reasons = manifest.reasons.join("; ");
    match manifest.verdict {
        Verdict::Complete => Ok(Exit::Fine),
        Verdict::Unsupported => Err(Failure::unsupported(anyhow!(reasons))),
        verdict => Err(anyhow!("{} is {verdict}: {reasons}", cell.id).into()),
    }
}

/// Keeps the processors from halting, if that is asked for.
pub(crate) fn awake(is_asked: bool, backend: Backend) -> Result<Option<Awake>, Failure> {
    match backend {
        _ if !is_asked => Ok(None),
        Backend::Netns => Awake::keep().map(Some).map_err(|problem| {
            Failure::unsupported(anyhow!(
                "cannot keep the processors awake ({problem}): --awake needs root on the machine itself"
            ))
        }),
        Backend::Compose | Backend::Attach | Backend::Sim => Err(Failure::usage(anyhow!(
            "--awake is for --backend netns: it keeps the processors of this machine awake"
        ))),
    }
}

/// What earlier runs have to match, for a run with these options.
pub(crate) fn own(backend: Backend, agents: Option<&Agents>, player: Player) -> Own {
    let is_asked = player != Player::Auto && backend != Backend::Sim;
    Own {
        // Agents may give their back-end a name of its own.
        backend: agents.map_or_else(|| word(&backend), |agents| agents.backend.clone()),
        player: is_asked.then(|| word(&player)),
    }
}

/// The command `run-cell` for a cell of a campaign; `run` starts it for each cell in real time.
///
/// # Errors
/// When this program cannot find its own file.
pub(crate) fn command<'a>(
    run: &'a Run,
    agents: Option<&'a Agents>,
    campaign: &'a CampaignFolder,
) -> anyhow::Result<impl Fn(&Turn<'_>, u8) -> Command + Sync + 'a> {
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    Ok(move |turn: &Turn<'_>, tries: u8| {
        let mut command = Command::new(&program);
        command
            .arg("run-cell")
            .arg("--plan")
            .arg(campaign.plan_file())
            .arg("--index")
            .arg(turn.cell.index.to_string())
            .arg("--out")
            .arg(campaign.path())
            .args(["--backend", &word(&run.backend)])
            .args(["--player", &word(&run.player)])
            .args(["--tries", &tries.to_string()])
            .args(["--together", &turn.together.to_string()])
            .args(["--not-before-ns", &turn.not_before_ns.to_string()]);
        if run.awake {
            command.arg("--awake");
        }
        command.envs(agents.map(|agents| (Token::VARIABLE, agents.token.reveal())));
        command
    })
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
