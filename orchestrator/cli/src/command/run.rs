//! `webloop run`: every cell of an experiment, and the table at the end.
//!
//! How the cells are run is in `jobs` for this machine and agents, in `containers` for Compose.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::sync::atomic::Ordering;

use anyhow::anyhow;
use backend::Agents;
use plan::{Cell, Instead, Plan, Verdict};

use crate::argument::{Backend, Choice, Progress as How, Run};
use crate::campaign::Campaign;
use crate::containers::ComposeRunner;
use crate::earlier::Own;
use crate::exit::{Exit, Failure, Outcome};
use crate::jobs::{self, Conditions};
use crate::progress::{Pace, Progress, cell_time, expected, people};
use crate::queue::Queue;
use crate::results::{Results, believed};
use crate::{attach, source, stop};

/// Resolves the experiment, runs its cells, prints the table.
pub(crate) fn run(argument: &Run) -> Outcome {
    if argument.backend != Backend::Attach || argument.dry_run {
        return run_all(argument, None);
    }
    let agents = attach::agents()?;
    let outcome = run_all(argument, Some(&agents));
    // Whatever came of it: nobody else will tell them that they are done.
    backend::dismiss(&agents);
    outcome
}

fn run_all(argument: &Run, agents: Option<&Agents>) -> Outcome {
    let instead = Instead {
        seed: argument.seed,
        topology: argument.topology.clone(),
        client: argument.client.clone(),
        full: argument.full,
    };
    let plan = source::plan_of(&argument.experiment, &instead)?;
    let chosen = choose(&plan, &argument.choice, &argument.experiment)?;
    let jobs = match (argument.backend, argument.jobs) {
        (Backend::Netns, jobs) => jobs,
        // Nothing is measured, so nothing is disturbed.
        (Backend::Sim, None) => Some(processors()),
        (Backend::Sim, jobs) => jobs,
        (Backend::Compose | Backend::Attach, None | Some(1)) => Some(1),
        (Backend::Compose | Backend::Attach, Some(jobs)) => {
            return Err(Failure::usage(anyhow!(
                "--jobs {jobs} is for --backend netns; in containers there is one plant"
            )));
        }
    };
    let pace = Pace {
        jobs,
        is_virtual: argument.backend == Backend::Sim,
    };
    if argument.dry_run {
        return dry_run(&chosen, pace);
    }
    let containers = match argument.backend {
        Backend::Compose => Some(ComposeRunner::find(!argument.no_build)?),
        Backend::Netns | Backend::Attach | Backend::Sim => None,
    };
    let latest = match argument.out.is_none() && (argument.resume || argument.failed) {
        true => Some(Campaign::latest(&plan)?),
        false => None,
    };
    let folder = argument.out.as_deref().or(latest.as_deref());
    let campaign = Campaign::open(&plan, folder)?;
    let stop = stop::told_to_end()?;
    if agents.is_some() {
        stop::give_up_soon_after(&stop)?;
    }
    let conditions = Conditions {
        backend: argument.backend,
        player: argument.player,
        agents,
        tries: argument.tries,
        timing: argument.timing.as_deref(),
    };
    let pending = pending(&chosen, &campaign, &Own::of(&conditions), argument.failed)?;
    if argument.progress != How::Quiet {
        eprintln!(
            "{}: {}, about {}, into {}",
            plan.experiment,
            match chosen.len() - pending.len() {
                0 => cells(pending.len()),
                others => format!("{} ({others} others are left alone)", cells(pending.len())),
            },
            people(expected(&pending, pace)),
            campaign.folder().display()
        );
    }
    let progress = Progress::start(argument.progress, &pending, pace);
    match containers {
        Some(containers) => containers.run(&pending, &campaign, &conditions, &stop, &progress)?,
        None => jobs::run(
            &match argument.backend {
                Backend::Sim => Queue::unmeasured(&pending, jobs.unwrap_or(1)),
                _ => Queue::new(&pending, jobs),
            },
            &campaign,
            &conditions,
            &stop,
            &progress,
        )?,
    }
    progress.finish();

    let asked: BTreeSet<&str> = chosen.iter().map(|cell| cell.id.as_str()).collect();
    let read = analysis::Campaign::read(campaign.folder())?;
    let results = Results::of(&read, |run| asked.contains(run.cell.id.as_str()))?;
    let table = results.table(false);
    let mut out = std::io::stdout();
    write!(out, "{table}")?;
    let folder = campaign.folder().display();
    writeln!(
        out,
        "\nResults: {folder}\nA report to open: webloop report {folder}"
    )?;
    let failed = results.rows.iter().filter(|row| {
        asked.contains(row.cell.as_str())
            && row
                .verdict
                .is_some_and(|verdict| !matches!(verdict, Verdict::Complete | Verdict::Unsupported))
    });
    match failed.count() {
        0 => {}
        count => writeln!(
            out,
            "{} did not hold; again: webloop run {} --out {folder} --failed",
            cells(count),
            argument.experiment
        )?,
    }
    // After the table, so that a full disk does not keep it from being seen.
    campaign.leave("summary.csv", results.csv().as_bytes())?;
    campaign.leave("table.txt", table.as_bytes())?;
    let verdicts = results
        .rows
        .iter()
        .filter(|row| asked.contains(row.cell.as_str()))
        .map(|row| row.verdict);
    Ok(exit(verdicts, stop.load(Ordering::Relaxed)))
}

/// The cells that are meant, at least one.
///
/// # Errors
/// Where there is none; says how to see which there are. Exit code 2.
pub(crate) fn choose<'a>(
    plan: &'a Plan,
    choice: &Choice,
    experiment: &str,
) -> Result<Vec<&'a Cell>, Failure> {
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
    match share.is_empty() {
        true => Err(Failure::usage(anyhow!(
            "--shard {shard} has nothing to do: {} can be shared out",
            cells(chosen.len())
        ))),
        false => Ok(share),
    }
}

/// By what cells are shared out: their length, and what comes before and after.
pub(crate) fn time_ns(cell: &Cell) -> u64 {
    u64::try_from(cell_time(cell).as_nanos()).unwrap_or(u64::MAX)
}

/// Those of the cells that are to be run: what is complete is left alone, and of the others only
/// what was run and `failed`, or is damaged, if that is asked for. What is damaged is moved aside
/// then.
///
/// # Errors
/// Where the folder's runs are not of this run's kind, exit code 2; where one that would be left alone
/// is damaged.
fn pending<'a>(
    chosen: &[&'a Cell],
    campaign: &Campaign,
    own: &Own,
    failed: bool,
) -> Result<Vec<&'a Cell>, Failure> {
    let read = analysis::Campaign::read(campaign.folder())?;
    for run in &read.runs {
        if let Some(manifest) = &run.manifest {
            own.check(&read.plan, manifest, &run.folder)?;
        }
    }
    let chosen: BTreeMap<&str, &'a Cell> = chosen.iter().map(|cell| (&*cell.id, *cell)).collect();
    let (mut pending, mut damaged) = (Vec::new(), Vec::new());
    for run in &read.runs {
        let cell = chosen.get(&*run.cell.id).copied();
        let is_whole = run.damage.is_empty();
        let is_due = match run.verdict() {
            Some(Verdict::Complete) => failed && !is_whole,
            Some(_) => true,
            None if is_whole => !failed,
            None => failed,
        };
        match cell {
            Some(cell) if is_due => pending.push(cell),
            _ if is_whole => {}
            _ => damaged.push(run),
        }
    }
    if !damaged.is_empty() {
        believed(&read)?;
    }
    for run in read.runs.iter().filter(|run| !run.damage.is_empty()) {
        backend::move_aside(&run.folder)?;
    }
    Ok(pending)
}

/// Lists the cells and runs nothing.
fn dry_run(chosen: &[&Cell], pace: Pace) -> Outcome {
    let mut out = std::io::stdout();
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

/// The worst verdict decides; a cell without one did not even leave a manifest.
pub(crate) fn exit(verdicts: impl Iterator<Item = Option<Verdict>>, interrupted: bool) -> Exit {
    if interrupted {
        return Exit::Interrupted;
    }
    match verdicts
        .map(|verdict| verdict.unwrap_or(Verdict::Failed))
        .max()
    {
        Some(Verdict::Complete) | None => Exit::Fine,
        Some(Verdict::Unsupported) => Exit::Unsupported,
        Some(_) => Exit::Failed,
    }
}

/// Processors that this process may use.
fn processors() -> u16 {
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    u16::try_from(count).unwrap_or(u16::MAX)
}

/// How many cells, as people say it.
pub(crate) fn cells(count: usize) -> String {
    match count {
        1 => "1 cell".to_owned(),
        n => format!("{n} cells"),
    }
}
