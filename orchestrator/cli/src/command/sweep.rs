//! `webloop sweep`: a loop over a grid of network conditions and settings, in virtual time.
//!
//! The crate `sweep` defines sweeps and their findings; `campaign` has their folder and threads.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::Ordering;

use backend::Timings;
use campaign::{Findings, SweepFolder};
use report::page::Sweep as Page;
use sweep::{Instead, SWEEPS};

use crate::argument::{Progress as How, Sweep};
use crate::exit::{Exit, Failure, Outcome};
use crate::sweep_progress::SweepProgress;
use crate::{source, stop};

/// The page of a sweep, in its folder.
const PAGE: &str = "report.html";

/// Runs a sweep's points, and prints and draws the findings.
pub(crate) fn run(argument: &Sweep) -> Outcome {
    if argument.schema {
        write!(crate::console::out(), "{}", sweep::schema())?;
        return Ok(Exit::Fine);
    }
    let Some(asked) = &argument.sweep else {
        return list();
    };
    let instead = Instead {
        seed: argument.seed,
        fixed: argument.fix.clone(),
    };
    let (text, sweep) = source::sweep(asked, &instead)?;
    if argument.dry_run {
        return dry_run(&sweep);
    }
    let timings = source::timings(argument.timing.as_deref())?;
    let fresh = || campaign::fresh(&format!("sweep-{}", sweep.name), sweep.seed);
    let path = argument.out.clone().unwrap_or_else(fresh);
    let mut folder = SweepFolder::open(&sweep, &text, &timings, &instead, &path)?;
    if let Some(torn) = folder.torn() {
        let torn = torn.display();
        say!("webloop: the last row of {torn} is cut off; its run is repeated");
    }
    if run_pending(argument, &sweep, &timings, &mut folder, &path)? {
        conclude(&sweep, folder, &path)
    } else {
        say!(
            "webloop: interrupted; {} of {} are kept; to continue, run the same command with --out \
             {}",
            folder.rows().len(),
            runs(sweep.runs()),
            path.display()
        );
        Ok(Exit::Interrupted)
    }
}

/// Runs what has no row yet, and sorts the rows once all are there. Returns whether they are.
fn run_pending(
    argument: &Sweep,
    sweep: &sweep::Sweep,
    timings: &Timings,
    folder: &mut SweepFolder<'_>,
    path: &Path,
) -> Result<bool, Failure> {
    let stop = stop::told_to_end()?;
    let pending = folder.pending();
    let threads = argument.jobs.map_or_else(processors, usize::from);
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
    let ended = campaign::threads::run(sweep, &pending, timings, threads, &stop, |rows| {
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

/// Prints the findings, and writes them into the folder.
fn conclude(sweep: &sweep::Sweep, folder: SweepFolder<'_>, path: &Path) -> Outcome {
    let findings = Findings::of(sweep, folder.rows());
    let mut out = crate::console::out();
    write!(out, "{}", findings.summary)?;
    findings.leave(&folder)?;
    let page = Page {
        name: &sweep.name,
        about: &sweep.about,
        seed: sweep.seed,
        summary: &findings.summary,
        maps: &findings.maps,
    };
    folder.leave(PAGE, page.render().as_bytes())?;
    folder.complete()?;
    writeln!(
        out,
        "\nResults: {}\nReport: {}",
        path.display(),
        path.join(PAGE).display()
    )?;
    Ok(Exit::Fine)
}

/// Lists the built-in sweeps.
fn list() -> Outcome {
    let mut out = crate::console::out();
    for (name, _) in SWEEPS {
        let (_, sweep) = source::sweep(name, &Instead::default())?;
        writeln!(
            out,
            "{name:<12} {}\n{:<12} {}",
            sweep.about,
            "",
            axes(&sweep).join(" × ")
        )?;
    }
    writeln!(out, "\nStart with: webloop sweep margin")?;
    Ok(Exit::Fine)
}

/// Prints what would be run.
fn dry_run(sweep: &sweep::Sweep) -> Outcome {
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

/// The axes with more than one level, each with its number of levels: `121 rtt`.
fn axes(sweep: &sweep::Sweep) -> Vec<String> {
    let dimensions = sweep.grid.dimensions();
    let several = dimensions.iter().filter(|d| d.levels.len() > 1);
    let mut axes: Vec<String> = several
        .map(|d| format!("{} {}", d.levels.len(), d.axis))
        .collect();
    if sweep.repeats > 1 {
        axes.push(format!("{} repeats", sweep.repeats));
    }
    axes
}

/// Number of processors that this process may use.
fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// A number of runs, as people say it.
fn runs(count: usize) -> String {
    match count {
        1 => "1 run".to_owned(),
        n => format!("{n} runs"),
    }
}
