//! `webloop agree A B`: can one results folder stand for the other, and where not?

use std::io::Write;

use analysis::Campaign;
use anyhow::anyhow;
use report::agree::Agreement;

use crate::argument::{Agree, AgreeFormat};
use crate::exit::{Exit, Failure, Outcome};

/// Reads both folders and prints where they agree and part.
pub(crate) fn run(argument: &Agree) -> Outcome {
    let read = |folder| Campaign::read(folder).map_err(Failure::usage);
    let (a, b) = (read(&argument.a)?, read(&argument.b)?);
    let agreement = Agreement::of(&a, &b);
    let mut out = std::io::stdout();
    match argument.format {
        AgreeFormat::Table => write!(
            out,
            "A: {}\nB: {}\n\n{}",
            argument.a.display(),
            argument.b.display(),
            agreement.to_text()
        )?,
        AgreeFormat::Json => write!(out, "{}", agreement.to_json())?,
    }
    // A check that holds nothing against anything must not let everything pass.
    if agreement.groups.is_empty() {
        return Err(Failure::usage(anyhow!(
            "no run of {} has its like in {}; give campaigns of equal seeds that are complete",
            argument.a.display(),
            argument.b.display()
        )));
    }
    match agreement.partings().next() {
        Some(_) => Ok(Exit::Failed),
        None => Ok(Exit::Fine),
    }
}
