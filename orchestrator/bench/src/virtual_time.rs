//! Virtual time: how many seconds of a loop at 1 kHz a second on one processor has.
//!
//! A run of webloop is whole: the cell's process, every row written, its manifest. What it takes to begin and
//! to end is taken off, by the difference of a long run and a short one.

use std::fs;
use std::process::Command;
use std::time::Instant;

use crate::Context;
use crate::contender::{Contender, Kind, Lack, Measured};
use crate::python;
use crate::role::output;

/// The base of the table.
pub(crate) const BASE: &str = "plain Python";

pub(crate) const CONTENDERS: [Contender; 4] = [
    Contender {
        name: BASE,
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| python::simulation("plain")),
    },
    Contender {
        name: "python-control",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| python::simulation("control")),
    },
    Contender {
        name: "webloop, arima",
        kind: Kind::Webloop,
        measure: |context| context.processors.on_one(|| webloop(context, "arima")),
    },
    Contender {
        name: "webloop, couva",
        kind: Kind::Webloop,
        measure: |context| context.processors.on_one(|| webloop(context, "couva")),
    },
];

fn webloop(context: &Context<'_>, topology: &str) -> Result<Measured, Lack> {
    const LONG_S: u32 = 420;
    const SHORT_S: u32 = 20;
    let [long_s, short_s] = [LONG_S, SHORT_S].map(|loop_s| wall_s(context, topology, loop_s));
    let x_real = f64::from(LONG_S - SHORT_S) / (long_s? - short_s?);
    Ok(vec![("x_real", x_real)])
}

/// How long a cell in virtual time takes, with its rows.
fn wall_s(context: &Context<'_>, topology: &str, loop_s: u32) -> Result<f64, Lack> {
    let file = context.folder.join(format!("{loop_s}.toml"));
    fs::write(
        &file,
        format!(
            "name = \"bench\"\n[[cells]]\ntopology = [\"{topology}\"]\nclient = [\"native\"]\n\
             mode = \"closed\"\nh = [\"1ms\"]\nduration = \"{loop_s}s\"\n"
        ),
    )?;
    let out = context.folder.join(format!("{loop_s}"));
    let mut command = Command::new(context.webloop);
    command.args(["run", "--backend", "sim", "--progress", "quiet"]);
    let begun = Instant::now();
    output(command.arg(&file).arg("--out").arg(&out))?;
    let took_s = begun.elapsed().as_secs_f64();
    fs::remove_dir_all(&out)?;
    Ok(took_s)
}
