//! `webloop gc`: removes the containers and networks that killed runs left.

use std::io::Write;

use containers::compose::{self, Order, Problem};

use crate::argument::Gc;
use crate::exit::{Exit, Failure, Outcome};

/// Sweeps, and prints what was removed, what stays, and why.
pub(crate) fn run(argument: &Gc) -> Outcome {
    let unsupported = |problem: Problem| match problem {
        Problem::Unsupported { .. } => Failure::unsupported(problem),
        _ => problem.into(),
    };
    compose::serves().map_err(unsupported)?;
    let swept = compose::gc(&Order {
        dry_run: argument.dry_run,
        force: argument.force,
        project: argument.project.clone(),
    })
    .map_err(unsupported)?;
    let mut out = crate::console::out();
    let verb = if argument.dry_run {
        "would remove"
    } else {
        "removed"
    };
    for thing in &swept.removed {
        writeln!(out, "{verb} {thing}")?;
    }
    for left in &swept.left {
        writeln!(out, "left {}: {}", left.thing, left.reason)?;
    }
    if swept.removed.is_empty() && swept.left.is_empty() {
        writeln!(out, "nothing of webloop's is there")?;
    }
    Ok(if swept.is_clean() {
        Exit::Fine
    } else {
        Exit::Failed
    })
}
