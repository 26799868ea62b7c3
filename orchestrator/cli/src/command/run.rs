//! `webloop run`: every cell of an experiment, and the table at the end; or its sweep, and the maps.
//!
//! The crate `campaign` runs the cells; `run_cell` is the program of a cell in real time.

mod conclusion;
mod pending;
mod ran;
mod swept;

use std::io::Write;
use std::sync::atomic::Ordering;

use analysis::campaign::Fresh;
use anyhow::anyhow;
use backend::Agents;
use campaign::{CampaignFolder, ComposeRunner, Pace, expected, time_ns};
use plan::{Cell, Instead, Plan};
use text::counted;

use crate::argument::{Backend, Choice, Progress as How, Run};
use crate::command::run_cell;
use crate::exit::{Exit, Failure, Outcome};
use crate::progress::{Progress, people};
use crate::{live, source, stop};

use self::conclusion::conclude;
pub(crate) use self::conclusion::page;
use self::pending::Pending;
pub(crate) use self::ran::{Ran, Read, exit};

/// Resolves the experiment, runs its cells, prints the table.
pub(crate) fn run(argument: &Run) -> Outcome {
    if argument.backend != Backend::Attach || argument.dry_run {
        return run_all(argument, None);
    }
    let agents = campaign::attach::agents()?;
    let outcome = run_all(argument, Some(&agents));
    // Whatever the outcome: nobody else tells the agents that they are done.
    backend::dismiss(&agents);
    outcome
}

fn run_all(argument: &Run, agents: Option<&Agents>) -> Outcome {
    run_plan(argument, &plan(argument)?, agents)
}

/// Runs a plan's cells, or its sweep.
pub(crate) fn run_plan(argument: &Run, plan: &Plan, agents: Option<&Agents>) -> Outcome {
    if let Some(sweep) = plan.swept().map_err(Failure::usage)? {
        return swept::run(argument, plan, &sweep);
    }
    let chosen = choose(plan, &argument.choice, argument.experiment())?;
    if argument.dry_run {
        return dry_run(&chosen, pace(argument)?);
    }
    let ran = execute(argument, plan, &chosen, agents)?;
    conclude(argument, &ran)
}

/// The plan that is asked for.
pub(crate) fn plan(argument: &Run) -> Result<Plan, Failure> {
    let replacement = &argument.instead;
    let instead = Instead {
        seed: argument.seed,
        topology: replacement.topology.clone(),
        client: replacement.client.clone(),
        system: replacement.system.clone(),
        h: replacement.h.iter().map(ToString::to_string).collect(),
        duration: replacement.duration.clone(),
        repeats: replacement.repeats,
        full: argument.full,
        fixed: argument.fix.clone(),
    };
    source::plan_of(argument.experiment(), &instead)
}

/// Runs the chosen cells of a plan.
pub(crate) fn execute<'a>(
    argument: &Run,
    plan: &'a Plan,
    chosen: &'a [&'a Cell],
    agents: Option<&Agents>,
) -> Result<Ran<'a>, Failure> {
    let pace = pace(argument)?;
    // Between the cells too, until all are done.
    let _awake = run_cell::awake(argument.awake, argument.backend)?;
    // Report what is missing or wrong before a folder is made.
    let timings = source::timings(argument.timing.as_deref())?;
    let containers = match argument.backend {
        Backend::Compose => Some(ComposeRunner::find(!argument.no_build)?),
        Backend::Netns | Backend::Attach | Backend::Sim => None,
    };
    let folder = open(argument, plan)?;
    let stop = stop::told_to_end()?;
    match agents {
        Some(_) => stop::give_up_soon_after(&stop)?,
        // Nothing runs yet, and to see which of a hundred thousand cells are done takes a minute.
        None => stop::at_once(),
    }
    let own = run_cell::own(argument.backend, agents, argument.player);
    let pending = campaign::pending(plan, chosen, &folder, &own, argument.failed)?;
    stop::by_flag();
    if argument.progress != How::Quiet {
        announce(plan, chosen, &pending, pace, &folder);
    }
    if let Some(address) = argument.live {
        let address = live::serve(address, folder.path())?;
        say!("Live: http://{address}/");
    }
    let progress = Progress::start(argument.progress, &pending, pace);
    let left = Pending {
        argument,
        plan,
        cells: &pending,
        folder: &folder,
        pace,
        stop: &stop,
        progress: &progress,
    };
    let mut fresh = Fresh::new();
    match (containers, argument.backend) {
        (Some(containers), _) => left.in_containers(&containers)?,
        (None, Backend::Sim) => fresh = left.in_virtual_time(timings, own)?,
        (None, _) => left.in_processes(agents)?,
    }
    progress.finish();
    if agents.is_none() {
        // Agents are still to be dismissed.
        stop::at_once();
    }
    Ok(Ran {
        plan,
        chosen,
        folder,
        is_interrupted: stop.load(Ordering::Relaxed),
        progress: argument.progress,
        fresh,
    })
}

/// How many cells run at a time, and in real or virtual time.
fn pace(argument: &Run) -> Result<Pace, Failure> {
    let jobs = match (argument.backend, argument.jobs) {
        (Backend::Netns, jobs) => jobs,
        // Nothing is measured, so nothing can be disturbed.
        (Backend::Sim, None) => Some(processors()),
        (Backend::Sim, jobs) => jobs,
        (Backend::Compose | Backend::Attach, None | Some(1)) => Some(1),
        (Backend::Compose | Backend::Attach, Some(jobs)) => {
            return Err(Failure::usage(anyhow!(
                "--jobs {jobs} is for --backend netns; in containers there is one plant"
            )));
        }
    };
    Ok(Pace {
        jobs,
        is_virtual: argument.backend == Backend::Sim,
    })
}

/// Opens the requested folder: a given one, the newest of this plan, or a new one.
fn open(argument: &Run, plan: &Plan) -> Result<CampaignFolder, Failure> {
    let is_latest = argument.out.is_none() && (argument.resume || argument.failed);
    let latest = is_latest
        .then(|| CampaignFolder::latest(plan))
        .transpose()?;
    let path = argument.out.as_deref().or(latest.as_deref());
    Ok(CampaignFolder::open(plan, path)?)
}

/// Prints what will be run, how long it takes, and where the results will be.
fn announce(plan: &Plan, chosen: &[&Cell], pending: &[&Cell], pace: Pace, folder: &CampaignFolder) {
    say!(
        "{}: {}, about {}, into {}",
        plan.experiment,
        match chosen.len() - pending.len() {
            0 => cells(pending.len()),
            others => format!("{} ({others} others are left alone)", cells(pending.len())),
        },
        people(expected(pending, pace)),
        folder.path().display()
    );
}

/// The selected cells, at least one.
///
/// # Errors
/// When no cell is selected; an error with exit code 2 that says how to list the cells.
pub(crate) fn choose<'a>(
    plan: &'a Plan,
    choice: &Choice,
    experiment: &str,
) -> Result<Vec<&'a Cell>, Failure> {
    if plan.sweep.is_some() {
        return Err(Failure::usage(anyhow!(
            "{experiment} is a sweep, whose points are no cells; `webloop run {experiment}` runs all of them"
        )));
    }
    let selection = choice.selection();
    let chosen = plan.chosen(&selection);
    if chosen.is_empty() {
        return Err(Failure::usage(anyhow!(
            "no cell of {experiment} matches {selection}; `webloop run {experiment} --dry-run` lists them"
        )));
    }
    let Some(shard) = choice.shard else {
        return Ok(chosen);
    };
    let share = shard.of(&chosen, time_ns);
    if share.is_empty() {
        Err(Failure::usage(anyhow!(
            "--shard {shard} has nothing to do: {} can be shared out",
            cells(chosen.len())
        )))
    } else {
        Ok(share)
    }
}

/// Lists the cells and runs nothing.
fn dry_run(chosen: &[&Cell], pace: Pace) -> Outcome {
    let mut out = crate::console::out();
    for cell in chosen {
        writeln!(
            out,
            "{:>4}  {:<46} {:>6} messages, link seed {}",
            cell.index,
            cell.id,
            cell.due(),
            cell.link_seed
        )?;
    }
    writeln!(
        out,
        "\n{}, about {}; nothing was run",
        cells(chosen.len()),
        people(expected(chosen, pace))
    )?;
    Ok(Exit::Fine)
}

/// Number of processors that this process may use.
fn processors() -> u16 {
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    u16::try_from(count).unwrap_or(u16::MAX)
}

/// A number of cells, as people say it.
pub(crate) fn cells(count: usize) -> String {
    counted(count, "cell", "cells")
}
