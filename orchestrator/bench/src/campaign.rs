//! Campaigns of equal cells, run by this binary as a user runs them.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use analysis::{Campaign, Run};

use crate::Context;
use crate::contender::Lack;
use crate::role::output;

/// Runs so many cells of the paper's loop at 1 kHz, with the native client, and makes no report. Gives
/// the folder of its results.
pub(crate) fn run(
    context: &Context<'_>,
    backend: &str,
    topology: &str,
    duration: &str,
    repeats: u32,
) -> Result<PathBuf, Lack> {
    let name = format!("{topology}-{duration}");
    let (file, out) = (
        context.folder.join(format!("{name}.toml")),
        context.folder.join(name),
    );
    fs::write(
        &file,
        format!(
            "name = \"bench\"\n[[cells]]\ntopology = [\"{topology}\"]\nclient = [\"native\"]\n\
             mode = \"closed\"\nh = [\"1ms\"]\nduration = \"{duration}\"\nrepeats = {repeats}\n"
        ),
    )?;
    let mut command = Command::new(context.webloop);
    command.args([
        "run",
        "--backend",
        backend,
        "--progress",
        "quiet",
        "--no-report",
    ]);
    output(command.arg(&file).arg("--out").arg(&out))?;
    Ok(out)
}

/// Runs one cell, and reads what it left.
pub(crate) fn run_one(
    context: &Context<'_>,
    backend: &str,
    topology: &str,
    duration: &str,
) -> Result<Run, Lack> {
    let out = run(context, backend, topology, duration, 1)?;
    let campaign = Campaign::read(&out).map_err(|error| Lack(error.to_string()))?;
    let run = campaign.runs.into_iter().next();
    run.ok_or_else(|| Lack("its run left no cell".to_owned()))
}
