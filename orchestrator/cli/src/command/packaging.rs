//! Shell completions and manual pages, for whoever packages webloop.

use std::fs;
use std::path::Path;

use crate::argument;
use crate::exit::{Exit, Outcome};
use anyhow::Context;

/// Prints completions for a shell.
pub(crate) fn completions(shell: clap_complete::Shell) -> Outcome {
    clap_complete::generate(
        shell,
        &mut argument::command(),
        "webloop",
        &mut crate::console::out(),
    );
    Ok(Exit::Fine)
}

/// Writes a manual page for each command.
pub(crate) fn man(folder: &Path) -> Outcome {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    clap_mangen::generate_to(argument::command(), folder)
        .with_context(|| format!("cannot write into {}", folder.display()))?;
    Ok(Exit::Fine)
}
