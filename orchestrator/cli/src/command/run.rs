//! `webloop run`: every cell of an experiment, one process each, and the table at the end.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, anyhow};
use plan::{Cell, Plan, Verdict};

use crate::argument::{Progress as How, Run};
use crate::campaign::Campaign;
use crate::exit::{Exit, Failure, Outcome};
use crate::progress::{Progress, people};
use crate::{results, source, stop};

/// How often a cell's process, and whether to stop, is looked at.
const POLL: Duration = Duration::from_millis(20);

/// Resolves the experiment, runs its cells, prints the table.
pub(crate) fn run(argument: &Run) -> Outcome {
    let mut plan = source::experiment(&argument.experiment, argument.seed)?;
    plan.keep(&argument.only);
    if plan.cells.is_empty() {
        return Err(Failure::usage(anyhow!(
            "no cell of {} matches {}; `webloop run {} --dry-run` lists them",
            argument.experiment,
            argument.only.join(" or "),
            argument.experiment
        )));
    }
    if argument.dry_run {
        return dry_run(&plan, argument.jobs);
    }
    let campaign = Campaign::open(&plan, argument.out.as_deref())?;
    let stop = stop::told_to_end()?;
    if argument.progress != How::Quiet {
        eprintln!(
            "{}: {}, about {}, into {}",
            plan.experiment,
            cells(&plan),
            people(expected(&plan, argument.jobs)),
            campaign.folder().display()
        );
    }
    let progress = Progress::start(
        argument.progress,
        plan.cells.len(),
        expected(&plan, argument.jobs),
    );
    run_cells(&plan, &campaign, argument.jobs, &stop, &progress)?;
    progress.finish();

    let rows = results::rows(campaign.folder(), &plan)?;
    let table = results::tables(&rows);
    let mut out = std::io::stdout();
    write!(out, "{table}")?;
    writeln!(out, "\nResults: {}", campaign.folder().display())?;
    // After the table, so that a full disk does not keep it from being seen.
    campaign.leave("summary.csv", analysis::Summary::to_csv(&rows).as_bytes())?;
    campaign.leave("table.txt", table.as_bytes())?;
    Ok(exit(&rows, stop.load(Ordering::Relaxed)))
}

/// Lists the cells and runs nothing.
fn dry_run(plan: &Plan, jobs: u16) -> Outcome {
    let mut out = std::io::stdout();
    for cell in &plan.cells {
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
        cells(plan),
        people(expected(plan, jobs))
    )?;
    Ok(Exit::Fine)
}

/// Runs the cells, `jobs` at a time, until all have ended or `stop` is set.
///
/// Each worker is a thread that lives as long as its cell's process, which dies with it.
fn run_cells(
    plan: &Plan,
    campaign: &Campaign,
    jobs: u16,
    stop: &AtomicBool,
    progress: &Progress,
) -> anyhow::Result<()> {
    let queue: Mutex<VecDeque<&Cell>> = Mutex::new(plan.cells.iter().collect());
    let next = || {
        queue
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop_front()
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs)
            .map(|_| {
                scope.spawn(|| {
                    while !stop.load(Ordering::Relaxed) {
                        let Some(cell) = next() else { break };
                        run_one(cell, campaign, stop, progress)?;
                    }
                    Ok(())
                })
            })
            .collect();
        workers.into_iter().try_for_each(|worker| {
            worker
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    })
}

/// Runs one cell in a process of its own: `webloop run-cell`; tells it to end once `stop` is set.
fn run_one(
    cell: &Cell,
    campaign: &Campaign,
    stop: &AtomicBool,
    progress: &Progress,
) -> anyhow::Result<()> {
    let bar = progress.begin(cell);
    let mut command =
        Command::new(std::env::current_exe().context("cannot find this program's own file")?);
    command
        .arg("run-cell")
        .arg("--plan")
        .arg(campaign.plan_file())
        .arg("--index")
        .arg(cell.index.to_string())
        .arg("--out")
        .arg(campaign.folder())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    backend::spawn::bind(&mut command, None::<&std::fs::File>)?;
    let mut child = command.spawn().context("cannot start a cell's process")?;
    // Read on a thread of its own, so that the process never blocks on a full pipe.
    let said = child.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut said = Vec::new();
            let _ = stderr.read_to_end(&mut said);
            String::from_utf8_lossy(&said).trim().to_owned()
        })
    });
    let status = loop {
        match child
            .try_wait()
            .context("cannot wait for a cell's process")?
        {
            Some(status) => break status,
            None if stop.load(Ordering::Relaxed) => backend::spawn::terminate(&mut child),
            None => {}
        }
        std::thread::sleep(POLL);
    };
    drop(bar);
    let said = said
        .and_then(|reader| reader.join().ok())
        .filter(|said| !said.is_empty())
        .unwrap_or_else(|| format!("its process ended with {status}"));
    let manifest =
        backend::manifest(campaign.folder(), cell).map_err(|problem| anyhow!(problem))?;
    let (verdict, reason) = match manifest {
        Some(manifest) => (manifest.verdict, manifest.reasons.join("; ")),
        // Without a manifest its own words are all there is.
        None => (Verdict::Failed, said),
    };
    progress.end(cell, cell_time(cell), verdict, &reason);
    Ok(())
}

/// The worst verdict decides; a cell without one did not even leave a manifest.
fn exit(rows: &[analysis::Summary], interrupted: bool) -> Exit {
    if interrupted {
        return Exit::Interrupted;
    }
    match rows
        .iter()
        .map(|row| row.verdict.unwrap_or(Verdict::Failed))
        .max()
    {
        Some(Verdict::Complete) | None => Exit::Fine,
        Some(Verdict::Unsupported) => Exit::Unsupported,
        Some(Verdict::Invalid | Verdict::Failed) => Exit::Failed,
    }
}

fn cell_time(cell: &Cell) -> Duration {
    Duration::from_nanos(cell.duration_ns + backend::overhead_ns())
}

fn expected(plan: &Plan, jobs: u16) -> Duration {
    plan.cells.iter().map(cell_time).sum::<Duration>() / u32::from(jobs)
}

/// How many cells, as people say it.
fn cells(plan: &Plan) -> String {
    match plan.cells.len() {
        1 => "1 cell".to_owned(),
        n => format!("{n} cells"),
    }
}
