//! A sweep of a plan, which is run in virtual time, whole: a loop over a grid of network conditions and settings.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::anyhow;
use backend::Timings;
use campaign::SweepFolder;
use plan::sweep::Sweep;
use plan::{Plan, Selection};
use report::sweep::{PAGE, SweepReport};
use text::counted;

use super::{open, processors};
use crate::argument::{Backend, Progress as How, Run};
use crate::exit::{Exit, Failure, Outcome};
use crate::sweep_progress::SweepProgress;
use crate::{source, stop};

/// Runs a sweep's points, and prints and draws the findings.
pub(super) fn run(argument: &Run, plan: &Plan, sweep: &Sweep) -> Outcome {
    check(argument)?;
    if argument.dry_run {
        return dry_run(sweep);
    }
    let timings = source::timings(argument.timing.as_deref())?;
    let folder = open(argument, plan)?;
    let mut rows = SweepFolder::open(sweep, &timings, &folder)?;
    if let Some(torn) = rows.torn() {
        let torn = torn.display();
        say!("webloop: the last row of {torn} is cut off; its run is repeated");
    }
    if !run_pending(argument, sweep, &timings, &mut rows, folder.path())? {
        say!(
            "webloop: interrupted; {} of {} are kept; to continue, run the same command with --out \
             {}",
            rows.rows().len(),
            runs(sweep.runs()),
            folder.path().display()
        );
        return Ok(Exit::Interrupted);
    }
    let report = SweepReport::of(sweep, rows.rows());
    let mut out = crate::console::out();
    write!(out, "{}", report.summary)?;
    writeln!(out, "\nResults: {}", folder.path().display())?;
    if !argument.no_report {
        for (name, content) in report.files() {
            folder.leave(&name.to_string_lossy(), &content)?;
        }
        writeln!(out, "Report: {}", folder.path().join(PAGE).display())?;
    }
    Ok(Exit::Fine)
}

/// Refuses options that have no meaning for a sweep.
fn check(argument: &Run) -> Result<(), Failure> {
    let choice = &argument.choice;
    let is_choice = choice.selection() != Selection::All || choice.shard.is_some();
    let is_elsewhere = matches!(argument.backend, Backend::Compose | Backend::Attach);
    let others = [
        ("--only, --cells and --shard choose among cells", is_choice),
        ("--failed is about cells", argument.failed),
        ("--require is about cells", !argument.require.is_empty()),
        ("--live shows cells", argument.live.is_some()),
        ("--backend runs cells elsewhere", is_elsewhere),
    ];
    match others.iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((words, _)) => Err(Failure::usage(anyhow!(
            "{words}, and a sweep has points, all in virtual time; leave it out, or fix an axis by --fix"
        ))),
    }
}

/// Runs what has no row yet, and sorts the rows once all are there. Returns whether they are.
fn run_pending(
    argument: &Run,
    sweep: &Sweep,
    timings: &Timings,
    folder: &mut SweepFolder<'_>,
    path: &Path,
) -> Result<bool, Failure> {
    let stop = stop::told_to_end()?;
    let pending = folder.pending();
    let threads = argument.jobs.unwrap_or_else(processors);
    let told = argument.progress != How::Quiet;
    if told {
        say!(
            "{}: {}, into {}",
            sweep.name,
            match folder.rows().len() {
                0 => runs(pending.len()),
                others => format!("{} ({others} others are there)", runs(pending.len())),
            },
            path.display()
        );
    }
    let mut progress = SweepProgress::start(argument.progress, pending.len());
    let ended = campaign::run_points(sweep, &pending, timings, threads.into(), &stop, |rows| {
        folder.add(rows)?;
        progress.add(rows.len());
        Ok(())
    });
    let took = progress.finish();
    ended?;
    if stop.load(Ordering::Relaxed) && !folder.pending().is_empty() {
        return Ok(false);
    }
    folder.settle()?;
    if told && !pending.is_empty() {
        say!("{} took {:.1} s", runs(pending.len()), took.as_secs_f64());
    }
    Ok(true)
}

/// Prints what would be run.
fn dry_run(sweep: &Sweep) -> Outcome {
    let mut out = crate::console::out();
    writeln!(out, "{}\n", sweep.about)?;
    for dimension in sweep.grid.dimensions() {
        let texts: Vec<&str> = dimension.levels.iter().map(|l| l.text.as_str()).collect();
        let levels = match texts[..] {
            [first, .., last] if texts.len() > 8 => {
                format!("{first} ... {last} ({} levels)", texts.len())
            }
            _ => texts.join(", "),
        };
        writeln!(out, "{:<12} {levels}", dimension.axis.column())?;
    }
    writeln!(
        out,
        "\n{} of {} s; nothing was run",
        runs(sweep.runs()),
        sweep.duration_ns as f64 / 1e9
    )?;
    Ok(Exit::Fine)
}

/// A number of runs, as people say it.
fn runs(count: usize) -> String {
    counted(count, "run", "runs")
}
