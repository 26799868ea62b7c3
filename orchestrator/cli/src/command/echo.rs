//! `webloop serve ask` and `serve hear`: the two halves of a probe, each beside its end.
//!
//! Whoever starts the halves decides which echoes are sent, and what they show about the link.

use std::fs::File;
use std::path::Path;

use anyhow::Context;
use plan::file_name;
use shaper::{Asker, ProbePlan, Record, Witness};

use crate::argument::ServeHalf;
use crate::command::serve::{read, say_ready};
use crate::exit::{Exit, Outcome};
use crate::stop;

/// Sends a series of echoes beside the controller, and writes them to `echoes-<id>.csv`.
pub(crate) fn ask(argument: &ServeHalf) -> Outcome {
    let plan: ProbePlan = read(&argument.settings)?;
    let stop = stop::told_to_end()?;
    let name = format!("echoes-{}.csv", plan.id);
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

/// Records each echo that reaches the plant in `sightings.csv`, until SIGTERM or SIGINT.
pub(crate) fn hear(argument: &ServeHalf) -> Outcome {
    let stop = stop::told_to_end()?;
    let mut record = Record::start(create(&argument.out, file_name::SIGHTINGS)?)?;
    let mut witness = Witness::open()?;
    say_ready(file_name::SIGHTINGS);
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
