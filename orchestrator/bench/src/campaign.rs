//! Campaigns of equal cells, run by the binary `webloop` as a user runs them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use analysis::{Campaign, Run};
use record::Manifest;

use crate::contender::Lack;
use crate::context::Context;
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
    let cells = format!(
        "topology = [\"{topology}\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"1ms\"]\n\
         duration = \"{duration}\"\nrepeats = {repeats}\n"
    );
    let out = context.folder.join(format!("{topology}-{duration}"));
    let words: &[&str] = match backend {
        "compose" => &["--no-build"],
        _ => &[],
    };
    run_cells(context, backend, words, &cells, &out)?;
    Ok(out)
}

/// Runs the cells that these lines of an experiment describe, without the first `[[cells]]`, and makes no report.
pub(crate) fn run_cells(
    context: &Context<'_>,
    backend: &str,
    words: &[&str],
    cells: &str,
    out: &Path,
) -> Result<(), Lack> {
    let file = out.with_extension("toml");
    fs::write(&file, format!("name = \"bench\"\n[[cells]]\n{cells}"))?;
    let mut command = Command::new(&context.programs.webloop);
    command.args(["run", "--backend", backend, "--progress", "quiet"]);
    command.arg("--no-report").args(words);
    output(command.arg(&file).arg("--out").arg(out)).map(drop)
}

/// Runs one cell, and reads what it left.
pub(crate) fn run_one(
    context: &Context<'_>,
    backend: &str,
    topology: &str,
    duration: &str,
) -> Result<Run, Lack> {
    first(&run(context, backend, topology, duration, 1)?)
}

/// Runs one cell in namespaces, described by lines of an experiment, and gives its manifest whatever its verdict
/// is: a run that is disturbed, or whose client is late, has its figures too.
pub(crate) fn judged(context: &Context<'_>, cells: &str) -> Result<Manifest, Lack> {
    let out = context.folder.join("cell");
    let ran = run_cells(context, "netns", &["--tries", "1"], cells, &out);
    let manifest = first(&out).ok().and_then(|run| run.manifest);
    match (manifest, ran) {
        (Some(manifest), _) => Ok(manifest),
        (None, Err(lack)) => Err(lack),
        (None, Ok(())) => Err(Lack("its cell has no manifest".to_owned())),
    }
}

fn first(folder: &Path) -> Result<Run, Lack> {
    let campaign = Campaign::read(folder).map_err(|error| Lack(error.to_string()))?;
    let run = campaign.runs.into_iter().next();
    run.ok_or_else(|| Lack("its run left no cell".to_owned()))
}
