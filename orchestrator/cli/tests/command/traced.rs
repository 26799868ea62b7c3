//! A run in virtual time under strace, for tests that watch or break its system calls.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) const WEBLOOP: &str = env!("CARGO_BIN_EXE_webloop");

/// Writes an experiment of so many short cells; `None`, which is said, if there is no strace.
pub(crate) fn experiment(place: &Path, repeats: usize) -> Option<PathBuf> {
    if Command::new("strace").arg("-V").output().is_err() {
        println!("SKIPPED: there is no strace to watch or break a run's system calls");
        return None;
    }
    let path = place.join("traced.toml");
    let text = format!(
        "name = \"traced\"\n[[cells]]\ntopology = [\"diego-vpn\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
         h = [\"10ms\"]\nduration = \"2s\"\nrepeats = {repeats}\n"
    );
    fs::write(&path, text).unwrap();
    Some(path)
}

/// strace of a program and its children that only writes what it is told to.
pub(crate) fn strace() -> Command {
    let mut strace = Command::new("strace");
    strace.args(["-f", "-qq"]);
    strace
}
