//! Runs a plan's cells, each in a process of its own: `webloop run-cell`.

use std::ffi::OsStr;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use agent::Token;
use anyhow::{Context, anyhow};
use backend::Agents;
use clap::ValueEnum;
use plan::Verdict;

use crate::argument::{Backend, Player};
use crate::campaign::Campaign;
use crate::progress::Progress;
use crate::queue::{Queue, Turn};

/// How often a cell's process, and whether to stop, is looked at.
const POLL: Duration = Duration::from_millis(20);

/// Where the cells are run, and by what.
pub(crate) struct Conditions<'a> {
    pub(crate) backend: Backend,
    pub(crate) player: Player,
    /// The agents, for the back-end that has them.
    pub(crate) agents: Option<&'a Agents>,
    /// How often a cell is run at most, while it is disturbed.
    pub(crate) tries: u8,
    /// What a machine's programs take, for virtual time.
    pub(crate) timing: Option<&'a Path>,
}

/// Runs the cells, as many at a time as the queue lets, until all have ended or `stop` is set.
///
/// Each worker is a thread that lives as long as its cell's process, which dies with it.
pub(crate) fn run(
    queue: &Queue<'_>,
    campaign: &Campaign,
    conditions: &Conditions<'_>,
    stop: &AtomicBool,
    progress: &Progress,
) -> anyhow::Result<()> {
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..queue.workers())
            .map(|_| {
                scope.spawn(|| {
                    while let Some(turn) = queue.next(stop) {
                        let outcome = run_one(&turn, campaign, conditions, stop, progress);
                        queue.end();
                        outcome?;
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
    turn: &Turn<'_>,
    campaign: &Campaign,
    conditions: &Conditions<'_>,
    stop: &AtomicBool,
    progress: &Progress,
) -> anyhow::Result<()> {
    let cell = turn.cell;
    // A cell that begins again would begin beside others that are measured.
    let tries = match turn.together {
        1 => conditions.tries,
        _ => 1,
    };
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
        .args(["--backend", &word(&conditions.backend)])
        .args(["--player", &word(&conditions.player)])
        .args(["--tries", &tries.to_string()])
        .args(["--together", &turn.together.to_string()])
        .args(["--not-before-ns", &turn.not_before_ns.to_string()])
        .args(
            conditions
                .timing
                .map(|file| [OsStr::new("--timing"), file.as_os_str()])
                .into_iter()
                .flatten(),
        )
        .envs(
            conditions
                .agents
                .map(|agents| (Token::VARIABLE, agents.token.reveal())),
        )
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
    progress.end(cell, verdict, &reason);
    Ok(())
}

/// A choice as it is typed.
pub(crate) fn word(choice: &impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}
