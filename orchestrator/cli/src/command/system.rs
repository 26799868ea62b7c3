//! `webloop system list|show|lint|schema`: plants with their laws, to choose from and to check.

use std::io::Write;

use anyhow::anyhow;
use plan::system::System;

use crate::argument::{SystemLint, SystemShow};
use crate::exit::{Exit, Failure, Outcome};
use crate::{diagnostic, source};

/// Lists the built-in systems.
pub(crate) fn list() -> Outcome {
    let mut out = crate::console::out();
    for name in System::built_in_names() {
        let system = source::system(name)?;
        writeln!(out, "{name:<18} {}", system.about())?;
    }
    Ok(Exit::Fine)
}

/// Prints a system's text, if it is valid.
pub(crate) fn show(show: &SystemShow) -> Outcome {
    source::system(&show.system)?;
    let text = source::system_text(&show.system).map_err(|problem| anyhow!(problem))?;
    write!(crate::console::out(), "{text}")?;
    Ok(Exit::Fine)
}

/// Prints the JSON schema of system files.
pub(crate) fn schema() -> Outcome {
    write!(crate::console::out(), "{}", plan::system::schema())?;
    Ok(Exit::Fine)
}

/// Checks system files.
pub(crate) fn lint(lint: &SystemLint) -> Outcome {
    let mut unfit = 0;
    for file in &lint.files {
        let origin = file.display().to_string();
        let text =
            source::system_text(&origin).map_err(|problem| Failure::usage(anyhow!(problem)))?;
        match System::read(&text) {
            Ok(system) => {
                let mut out = crate::console::out();
                writeln!(out, "{origin}: {} can be run", system.name())?;
                for warning in system.warnings() {
                    writeln!(out, "{origin}: warning: {warning}")?;
                }
            }
            Err(fault) => {
                diagnostic::draw(&text, &origin, &fault);
                unfit += 1;
            }
        }
    }
    match unfit {
        0 => Ok(Exit::Fine),
        1 => Err(Failure::usage(anyhow!("one system cannot be run"))),
        n => Err(Failure::usage(anyhow!("{n} systems cannot be run"))),
    }
}
