//! `webloop compare A B`: is the second results folder worse than the first?

use std::io::Write;

use analysis::{Campaign, Run};
use anyhow::anyhow;
use plan::Selection;
use report::compare::{Answer, Comparison, lost};

use crate::argument::{Compare, CompareFormat, UNDECIDED, Undecided};
use crate::exit::{Exit, Failure, Outcome};
use crate::results::{self, are_whole, tell_damage};

/// Reads both folders and prints how they compare.
pub(crate) fn run(argument: &Compare) -> Outcome {
    let Compare {
        a,
        b,
        change_pct,
        allow_missing,
        allow,
        format,
    } = argument;
    let both = (results::read(a)?, results::read(b)?);
    let (undecided, allow) = split(allow);
    let is_allowed = allowed(&allow, [&both.0, &both.1])?;
    let comparison = Comparison::of(&both.0, &both.1, change_pct / 1e2);
    let paths = (a.as_path(), b.as_path());
    let (a, b) = (a.display().to_string(), b.display().to_string());
    let text = match format {
        CompareFormat::Table => comparison.to_text(&a, &b),
        CompareFormat::Csv => comparison.to_csv(),
        CompareFormat::Json => comparison.to_json(),
    };
    write!(crate::console::out(), "{text}")?;
    // A check that compares nothing must not pass.
    if comparison.groups.is_empty() {
        tell_damage(&both.0, |_| false);
        tell_damage(&both.1, |_| false);
        return Err(Failure::usage(anyhow!(
            "no run of {a} has a counterpart in {b}; compare complete campaigns of equal seeds"
        )));
    }
    let lost = lost(&both.0, &both.1).into_iter();
    let lost = lost.filter(|run| !*allow_missing && !is_allowed(run));
    let lost = lost.map(|run| {
        say!(
            "webloop: {}: {} is complete, and {b} does not have it",
            paths.0.display(),
            run.cell.id
        );
    });
    let lost = lost.count();
    let campaigns = [(&both.0, paths.0), (&both.1, paths.1)];
    let are_whole = are_whole(campaigns, *allow_missing, is_allowed);
    let passes = match comparison.answer {
        Answer::Worse => false,
        Answer::NotWorse => true,
        Answer::CannotTell => undecided == Undecided::Passes,
    };
    if are_whole && lost == 0 && passes {
        Ok(Exit::Fine)
    } else {
        Ok(Exit::Failed)
    }
}

/// The word `undecided` among what is allowed, and the other words, which are patterns of cells.
fn split(allow: &[String]) -> (Undecided, Vec<String>) {
    let patterns: Vec<String> = allow
        .iter()
        .filter(|word| *word != UNDECIDED)
        .cloned()
        .collect();
    let undecided = if patterns.len() < allow.len() {
        Undecided::Passes
    } else {
        Undecided::Fails
    };
    (undecided, patterns)
}

/// Whether `--allow` accepts that a run is not there. Each pattern has to name a cell, or it would accept nothing
/// without saying so.
fn allowed(patterns: &[String], both: [&Campaign; 2]) -> Result<impl Fn(&Run) -> bool, Failure> {
    for pattern in patterns {
        let one = Selection::Matching(vec![pattern.clone()]);
        let mut runs = both.iter().flat_map(|campaign| &campaign.runs);
        if !runs.any(|run| one.takes(&run.cell)) {
            return Err(Failure::usage(anyhow!(
                "--allow {pattern}: no cell of either folder matches; leave it out"
            )));
        }
    }
    let all = Selection::Matching(patterns.to_vec());
    Ok(move |run: &Run| all.takes(&run.cell))
}
