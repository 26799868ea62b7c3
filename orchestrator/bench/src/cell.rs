//! A cell: how long it takes beyond its own loop, from its first process until its manifest is on the disk.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use manifest::Manifest;

use crate::Context;
use crate::contender::{Contender, Kind, Lack, Measured};
use crate::role::output;

/// The base of the table.
pub(crate) const BASE: &str = "namespaces, arima";

pub(crate) const CONTENDERS: [Contender; 4] = [
    Contender {
        name: BASE,
        kind: Kind::Webloop,
        measure: |context| real(context, "arima"),
    },
    Contender {
        name: "namespaces, buccoo",
        kind: Kind::Webloop,
        measure: |context| real(context, "buccoo"),
    },
    Contender {
        name: "namespaces, couva",
        kind: Kind::Webloop,
        measure: |context| real(context, "couva"),
    },
    Contender {
        name: "virtual time, arima",
        kind: Kind::Webloop,
        measure: simulated,
    },
];

/// Runs an experiment of equal cells, and gives the folder of its results.
fn run(
    context: &Context<'_>,
    backend: &str,
    topology: &str,
    duration: &str,
    repeats: u32,
) -> Result<std::path::PathBuf, Lack> {
    let (file, out) = (
        context.folder.join("bench.toml"),
        context.folder.join("out"),
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

fn real(context: &Context<'_>, topology: &str) -> Result<Measured, Lack> {
    const LOOP_S: f64 = 1.0;
    let out = run(context, "netns", topology, "1s", 1)?;
    let wall_s = manifests(&out)?
        .iter()
        .map(|manifest| manifest.wall_s)
        .sum::<f64>();
    Ok(vec![("beyond_ms", (wall_s - LOOP_S) * 1e3)])
}

/// The paper's loop of 2.5 s, as often as `webloop run paper` has it.
fn simulated(context: &Context<'_>) -> Result<Measured, Lack> {
    const CELLS: u32 = 100;
    let begun = Instant::now();
    run(context, "sim", "arima", "2500ms", CELLS)?;
    let took_ms = begun.elapsed().as_secs_f64() * 1e3;
    Ok(vec![("beyond_ms", took_ms / f64::from(CELLS))])
}

fn manifests(out: &Path) -> Result<Vec<Manifest>, Lack> {
    let mut manifests = Vec::new();
    for cell in fs::read_dir(out.join("cells"))? {
        let text = fs::read_to_string(cell?.path().join("manifest.json"))?;
        let manifest = serde_json::from_str(&text);
        manifests.push(manifest.map_err(|error| Lack(format!("its manifest: {error}")))?);
    }
    Ok(manifests)
}
