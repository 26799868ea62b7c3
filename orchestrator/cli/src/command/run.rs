//! `webloop run`: every cell of an experiment, and the table at the end.
//!
//! The crate `campaign` runs the cells; `run_cell` is the program of a cell in real time.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use analysis::Campaign;
use analysis::expect::{Judgement, judge};
use anyhow::{Context, anyhow};
use backend::{Agents, Virtual};
use campaign::{
    CampaignFolder, CellRun, ComposeRunner, Inside, Pace, Processes, Queue, Results, expected,
    time_ns,
};
use plan::{Cell, Clause, Day, Instead, Plan, Verdict, file_name};

use crate::argument::{Backend, Choice, Progress as How, Run, word};
use crate::command::{self, run_cell};
use crate::exit::{Exit, Failure, Outcome};
use crate::progress::{Progress, people};
use crate::{live, source, stop};

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
    let plan = plan(argument)?;
    let chosen = choose(&plan, &argument.choice, argument.experiment())?;
    if argument.dry_run {
        return dry_run(&chosen, pace(argument)?);
    }
    let ran = execute(argument, &plan, &chosen, agents)?;
    conclude(argument, &ran)
}

/// The plan that is asked for.
pub(crate) fn plan(argument: &Run) -> Result<Plan, Failure> {
    let instead = Instead {
        seed: argument.seed,
        topology: argument.topology.clone(),
        client: argument.client.clone(),
        full: argument.full,
    };
    source::plan_of(argument.experiment(), &instead)
}

/// Cells that were run, and their folder.
pub(crate) struct Ran<'a> {
    chosen: &'a [&'a Cell],
    folder: CampaignFolder,
    is_interrupted: bool,
}

/// Runs the chosen cells of a plan.
pub(crate) fn execute<'a>(
    argument: &Run,
    plan: &Plan,
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
    if agents.is_some() {
        stop::give_up_soon_after(&stop)?;
    }
    let own = run_cell::own(argument.backend, agents, argument.player);
    let pending = campaign::pending(chosen, &folder, &own, argument.failed)?;
    if argument.progress != How::Quiet {
        announce(plan, chosen, &pending, pace, &folder);
    }
    if let Some(address) = argument.live {
        let address = live::serve(address, folder.path())?;
        say!("Live: http://{address}/");
    }
    let progress = Progress::start(argument.progress, &pending, pace);
    match containers {
        Some(containers) => {
            let tries = argument.tries.to_string();
            let inside = Inside {
                plan,
                campaign: folder.path(),
                tries: argument.tries,
                options: &["--player", &word(&argument.player), "--tries", &tries],
            };
            containers.run(&pending, &inside, &stop, &progress)?;
        }
        None if argument.backend == Backend::Sim => {
            let queue = Queue::unmeasured(&pending, pace.jobs.unwrap_or(1));
            let how = CellRun {
                campaign: folder.path(),
                backend: &backend::Backend::Sim(Box::new(Virtual::new(timings))),
                player: argument.player.into(),
                own,
                tries: argument.tries,
                together: 1,
            };
            let words = |problem: campaign::Error| crate::exit::words(&problem.into());
            campaign::simulate(&queue, plan, &how, &stop, &progress, words)?;
        }
        None => {
            let queue = Queue::new(&pending, pace.jobs, shaper::now_ns);
            let program = Processes(run_cell::command(argument, agents, &folder)?);
            let tries = argument.tries;
            campaign::run(&queue, folder.path(), &program, tries, &stop, &progress)?;
        }
    }
    progress.finish();
    Ok(Ran {
        chosen,
        folder,
        is_interrupted: stop.load(Ordering::Relaxed),
    })
}

impl Ran<'_> {
    /// Reads the folder.
    pub(crate) fn read(&self) -> Result<Campaign, Failure> {
        Ok(Campaign::read(self.folder.path())?)
    }

    /// The runs of the chosen cells.
    pub(crate) fn asked<'a>(&self, read: &'a Campaign) -> Vec<&'a analysis::Run> {
        let asked: BTreeSet<&str> = self.chosen.iter().map(|cell| cell.id.as_str()).collect();
        let is_asked = |run: &&analysis::Run| asked.contains(run.cell.id.as_str());
        read.runs.iter().filter(is_asked).collect()
    }

    /// The exit code of the runs alone.
    pub(crate) fn exit(&self, asked: &[&analysis::Run]) -> Exit {
        exit(asked.iter().map(|run| run.verdict()), self.is_interrupted)
    }
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

/// Prints the table and where the results are, and writes the table into the folder, also as CSV.
fn conclude(argument: &Run, ran: &Ran<'_>) -> Outcome {
    let read = ran.read()?;
    let asked = ran.asked(&read);
    let ids: BTreeSet<&str> = asked.iter().map(|run| run.cell.id.as_str()).collect();
    let results = Results::of(&read, |run| ids.contains(run.cell.id.as_str()))?;
    let table = results.table(false);
    let mut out = crate::console::out();
    write!(out, "{table}")?;
    let folder = ran.folder.path().display();
    writeln!(out, "\nResults: {folder}")?;
    let did_not_hold = |run: &&&analysis::Run| {
        let verdict = run.verdict();
        verdict.is_some_and(|verdict| !matches!(verdict, Verdict::Complete | Verdict::Unsupported))
    };
    match asked.iter().filter(did_not_hold).count() {
        0 => {}
        count => writeln!(
            out,
            "{} did not hold; again: webloop run {} --out {folder} --failed",
            cells(count),
            argument.experiment()
        )?,
    }
    let judgement = judged(&read.plan, &asked, &argument.require);
    print(&judgement, &mut out)?;
    // Written after the table is printed, so that a full disk does not hide it.
    ran.folder
        .leave(file_name::SUMMARY, results.csv().as_bytes())?;
    ran.folder.leave(file_name::TABLE, table.as_bytes())?;
    if !argument.no_report && !ran.is_interrupted {
        let page = leave_report(&read, judgement.clone())?;
        writeln!(out, "Report: {}", page.display())?;
    }
    Ok(match ran.exit(&asked) {
        Exit::Fine | Exit::Unsupported if !judgement.holds() => Exit::Failed,
        exit => exit,
    })
}

/// Writes the report into the campaign's folder; returns the path of its page.
pub(crate) fn leave_report(read: &Campaign, judgement: Judgement) -> Result<PathBuf, Failure> {
    let report = command::report::of(read, None)?.with_expectations(judgement);
    let folder = read.folder.join(file_name::REPORT);
    file::check_folder(&folder).map_err(Failure::usage)?;
    report::write(&report.files(), &folder)
        .with_context(|| format!("cannot write the report into {}", folder.display()))?;
    Ok(folder.join("report.html"))
}

/// Asks runs what is expected of them today.
pub(crate) fn judged(plan: &Plan, runs: &[&analysis::Run], required: &[Clause]) -> Judgement {
    let now = jiff::Timestamp::now().to_zoned(jiff::tz::TimeZone::UTC);
    judge(plan, runs, required, Day::from(now.date()))
}

/// Prints whether the runs show what is expected: a line for each clause and group that it is asked of.
pub(crate) fn print(judgement: &Judgement, out: &mut impl Write) -> std::io::Result<()> {
    if judgement.is_empty() {
        return Ok(());
    }
    write!(out, "\n{judgement}")
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

/// The exit code of the worst verdict. A cell without a verdict left no manifest, so it failed.
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

/// Number of processors that this process may use.
fn processors() -> u16 {
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    u16::try_from(count).unwrap_or(u16::MAX)
}

/// A number of cells, as people say it.
pub(crate) fn cells(count: usize) -> String {
    match count {
        1 => "1 cell".to_owned(),
        n => format!("{n} cells"),
    }
}
