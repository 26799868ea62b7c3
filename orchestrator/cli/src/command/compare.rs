//! `webloop compare A B`: is the second results folder worse than the first?

use std::io::Write;

use analysis::Campaign;
use anyhow::anyhow;
use report::compare::Comparison;

use crate::argument::{Compare, CompareFormat};
use crate::exit::{Exit, Failure, Outcome};
use crate::results::{are_whole, tell_damage};

/// Reads both folders and prints how they compare.
pub(crate) fn run(argument: &Compare) -> Outcome {
    let Compare {
        a,
        b,
        change_pct,
        allow_missing,
        format,
    } = argument;
    let read = |folder| Campaign::read(folder).map_err(Failure::usage);
    let both = (read(a)?, read(b)?);
    let comparison = Comparison::of(&both.0, &both.1, change_pct / 1e2);
    let paths = (a, b);
    let (a, b) = (a.display().to_string(), b.display().to_string());
    let text = match format {
        CompareFormat::Table => comparison.to_text(&a, &b),
        CompareFormat::Csv => comparison.to_csv(),
        CompareFormat::Json => comparison.to_json(),
    };
    write!(std::io::stdout(), "{text}")?;
    // A check that compares nothing must not pass.
    if comparison.groups.is_empty() {
        tell_damage(&both.0);
        tell_damage(&both.1);
        return Err(Failure::usage(anyhow!(
            "no run of {a} has a counterpart in {b}; compare complete campaigns of equal seeds"
        )));
    }
    let are_whole = are_whole([(&both.0, paths.0), (&both.1, paths.1)], *allow_missing);
    if are_whole && !comparison.is_worse() {
        Ok(Exit::Fine)
    } else {
        Ok(Exit::Failed)
    }
}
