//! `webloop agree A B`: can one results folder stand for the other, and where not?

use std::io::Write;

use analysis::Campaign;
use anyhow::anyhow;
use report::agree::Agreement;

use crate::argument::{Agree, AgreeFormat};
use crate::exit::{Exit, Failure, Outcome};
use crate::results::{self, are_whole, tell_damage};

/// Reads both folders and prints where they agree and where they differ.
pub(crate) fn run(argument: &Agree) -> Outcome {
    let (a, b) = (results::read(&argument.a)?, results::read(&argument.b)?);
    let agreement = Agreement::of(&a, &b);
    let mut out = crate::console::out();
    match argument.format {
        AgreeFormat::Table => write!(
            out,
            "A: {}{}\nB: {}{}\n\n{}",
            argument.a.display(),
            simulated(&a),
            argument.b.display(),
            simulated(&b),
            agreement.to_text()
        )?,
        AgreeFormat::Json => write!(out, "{}", agreement.to_json())?,
    }
    // A check that compares nothing must not pass.
    if agreement.groups.is_empty() {
        tell_damage(&a, |_| false);
        tell_damage(&b, |_| false);
        return Err(Failure::usage(anyhow!(
            "no run of {} has a counterpart in {}; give complete campaigns of equal seeds",
            argument.a.display(),
            argument.b.display()
        )));
    }
    let are_whole = are_whole(
        [(&a, &argument.a), (&b, &argument.b)],
        argument.allow_missing,
        |_| false,
    );
    match agreement.partings().next() {
        None if are_whole => Ok(Exit::Fine),
        _ => Ok(Exit::Failed),
    }
}

/// The remark on a folder in virtual time.
fn simulated(campaign: &Campaign) -> &'static str {
    if campaign.is_simulated() {
        ", simulated"
    } else {
        ""
    }
}
