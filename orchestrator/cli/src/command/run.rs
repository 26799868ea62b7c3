//! `webloop run`: every cell of an experiment, and the table at the end.
//!
//! How the cells are run is in `jobs` for this machine and agents, in `containers` for Compose.

use std::collections::BTreeSet;
use std::io::Write;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::anyhow;
use backend::Agents;
use plan::{Cell, Instead, Plan, Verdict};

use crate::argument::{Backend, Choice, Progress as How, Run};
use crate::campaign::Campaign;
use crate::containers::Docks;
use crate::exit::{Exit, Failure, Outcome};
use crate::jobs::{self, Ground};
use crate::progress::{Progress, people};
use crate::results::Results;
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
    };
    let plan = source::plan_of(&argument.experiment, &instead)?;
    let chosen = choose(&plan, &argument.choice, &argument.experiment)?;
    if argument.jobs > 1 && argument.backend != Backend::Netns {
        return Err(Failure::usage(anyhow!(
            "--jobs {} is for --backend netns; in containers there is one plant",
            argument.jobs
        )));
    }
    if argument.dry_run {
        return dry_run(&chosen, argument.jobs);
    }
    let docks = match argument.backend {
        Backend::Compose => Some(Docks::find(!argument.no_build)?),
        Backend::Netns | Backend::Attach => None,
    };
    let campaign = Campaign::open(&plan, argument.out.as_deref())?;
    let stop = stop::told_to_end()?;
    if agents.is_some() {
        stop::give_up_soon_after(&stop)?;
    }
    let expected = expected(&chosen) / u32::from(argument.jobs);
    if argument.progress != How::Quiet {
        eprintln!(
            "{}: {}, about {}, into {}",
            plan.experiment,
            cells(chosen.len()),
            people(expected),
            campaign.folder().display()
        );
    }
    let progress = Progress::start(argument.progress, chosen.len(), expected);
    let ground = Ground {
        backend: argument.backend,
        player: argument.player,
        agents,
    };
    match docks {
        Some(docks) => docks.run(&chosen, &campaign, &ground, &stop, &progress)?,
        None => jobs::run(&chosen, &campaign, &ground, argument.jobs, &stop, &progress)?,
    }
    progress.finish();

    let asked: BTreeSet<&str> = chosen.iter().map(|cell| cell.id.as_str()).collect();
    let results = Results::read(campaign.folder(), &plan, |cell| {
        asked.contains(cell.id.as_str())
    })?;
    let table = results.table();
    let mut out = std::io::stdout();
    write!(out, "{table}")?;
    writeln!(out, "\nResults: {}", campaign.folder().display())?;
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
    Ok(chosen)
}

/// Lists the cells and runs nothing.
fn dry_run(chosen: &[&Cell], jobs: u16) -> Outcome {
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
        people(expected(chosen) / u32::from(jobs))
    )?;
    Ok(Exit::Fine)
}

/// The worst verdict decides; a cell without one did not even leave a manifest.
fn exit(verdicts: impl Iterator<Item = Option<Verdict>>, interrupted: bool) -> Exit {
    if interrupted {
        return Exit::Interrupted;
    }
    match verdicts
        .map(|verdict| verdict.unwrap_or(Verdict::Failed))
        .max()
    {
        Some(Verdict::Complete) | None => Exit::Fine,
        Some(Verdict::Unsupported) => Exit::Unsupported,
        Some(Verdict::Invalid | Verdict::Failed) => Exit::Failed,
    }
}

pub(crate) fn cell_time(cell: &Cell) -> Duration {
    Duration::from_nanos(cell.duration_ns + backend::overhead_ns(cell.client))
}

/// How long these cells take, one after another.
pub(crate) fn expected(cells: &[&Cell]) -> Duration {
    cells.iter().map(|cell| cell_time(cell)).sum()
}

/// How many cells, as people say it.
pub(crate) fn cells(count: usize) -> String {
    match count {
        1 => "1 cell".to_owned(),
        n => format!("{n} cells"),
    }
}
