//! Campaigns of equal cells, run by this binary as a user runs them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use manifest::Manifest;

use crate::Context;
use crate::contender::Lack;
use crate::role::output;

/// Runs so many cells of the paper's loop at 1 kHz, with the native client. Gives the folder of its results.
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
    command.args(["run", "--backend", backend, "--progress", "quiet"]);
    output(command.arg(&file).arg("--out").arg(&out))?;
    Ok(out)
}

/// The folders of its cells, with their manifests.
pub(crate) fn cells(out: &Path) -> Result<Vec<(PathBuf, Manifest)>, Lack> {
    let mut cells = Vec::new();
    for entry in fs::read_dir(out.join(plan::file_name::CELLS))? {
        let folder = entry?.path();
        let text = fs::read_to_string(folder.join(Manifest::FILE))?;
        let manifest = Manifest::from_json(&text);
        let manifest = manifest.map_err(|error| Lack(format!("its manifest: {error}")))?;
        cells.push((folder, manifest));
    }
    Ok(cells)
}
