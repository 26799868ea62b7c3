//! `webloop doctor`: what this machine can do, what is missing, and what to do about it.

mod others;

use std::fmt::Display;
use std::io::Write;

use backend::ability::{Need, abilities};

use crate::exit::{Exit, Outcome};

/// Tries everything that a run needs, and prints what it found.
pub(crate) fn run() -> Outcome {
    // First of all: a user namespace can only be entered while there is one thread.
    let authority = shaper::become_root();
    let machine = backend::machine();
    let mut out = crate::console::out();
    writeln!(
        out,
        "{}, {} on {} processors ({}), {} MiB, clock {}\n",
        machine.kernel,
        machine.architecture,
        machine.cores,
        machine.processor,
        machine.memory_mib,
        machine.clock_source
    )?;
    let mut missing = false;
    let all = abilities(&authority).into_iter();
    for ability in all.chain(others::clients()).chain(others::containers()) {
        let (mark, text): (_, &dyn Display) = match (&ability.found, ability.need) {
            (Ok(text), _) => ("ok", text),
            (Err(text), Need::Must) => ("MISSING", text),
            (Err(text), Need::Better) => ("without", text),
        };
        writeln!(out, "{mark:>7}  {:<26} {text}", ability.what)?;
        if ability.found.is_err() {
            writeln!(out, "{:>7}  {:<26} -> {}", "", "", ability.remedy)?;
            missing |= ability.need == Need::Must;
        }
    }
    if missing {
        writeln!(
            out,
            "\nThis machine cannot run the loop over emulated links yet."
        )?;
        Ok(Exit::Unsupported)
    } else {
        writeln!(out, "\nThis machine can run every experiment: webloop run")?;
        Ok(Exit::Fine)
    }
}
