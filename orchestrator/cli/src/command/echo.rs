//! `webloop serve ask` and `serve hear`: the two halves of a probe, each beside its end.
//!
//! Which echoes are sent, and what they say of the link, is decided by whoever starts the halves.

use std::fs::File;
use std::path::Path;

use anyhow::Context;
use shaper::{Asker, ProbePlan, Record, Witness};

use crate::argument::{ServeAsk, ServeHear};
use crate::command::serve::say_ready;
use crate::exit::{Exit, Outcome};
use crate::stop;

/// Sends a series of echoes beside the controller, and leaves them as `echoes-<id>.csv`.
pub(crate) fn ask(argument: &ServeAsk) -> Outcome {
    let plan = ProbePlan {
        target: argument.target,
        start_ns: argument.start_ns,
        interval_ns: argument.interval_ns,
        count: argument.count,
        seed: argument.seed,
        grace_ns: argument.grace_ns,
        id: argument.id,
    };
    let stop = stop::told_to_end()?;
    let name = format!("echoes-{}.csv", argument.id);
    let mut rows = csv::Writer::from_writer(create(&argument.out, &name)?);
    let mut asker = Asker::open()?;
    say_ready(&name);
    for echo in asker.run(&plan, &stop, |_| {})? {
        rows.serialize(echo)?;
    }
    rows.flush()
        .with_context(|| format!("cannot write {name}; free space"))?;
    Ok(Exit::Fine)
}

/// Writes down each echo that reaches the plant, in `sightings.csv`, until SIGTERM or SIGINT.
pub(crate) fn hear(argument: &ServeHear) -> Outcome {
    let stop = stop::told_to_end()?;
    let mut record = Record::start(create(&argument.out, "sightings.csv")?)?;
    let mut witness = Witness::open()?;
    say_ready("sightings.csv");
    witness.run(&stop, |sighting| record.add([sighting]))?;
    record
        .finish()
        .context("cannot write sightings.csv; free space")?;
    Ok(Exit::Fine)
}

fn create(folder: &Path, name: &str) -> anyhow::Result<File> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let path = folder.join(name);
    File::create(&path).with_context(|| format!("cannot write {}", path.display()))
}
