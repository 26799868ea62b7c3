//! The program for real: processes, namespaces and sockets, and the binary `webloop` beside it.
//!
//! This test has a main function of its own instead of the usual harness: tests that take wall-clock time must not run
//! at the same time, and tests that the machine does not allow are reported as skipped.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod table;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serial::Trial;

/// The program that this test was built with.
const BENCH: &str = env!("CARGO_BIN_EXE_webloop-bench");

/// What it measures: cargo puts it beside, and builds it for this test only with the whole workspace.
fn webloop() -> PathBuf {
    Path::new(BENCH).with_file_name("webloop")
}

/// Why this machine cannot measure, if so.
fn lack() -> Option<String> {
    let webloop = webloop();
    if !webloop.is_file() {
        let path = webloop.display();
        return Some(format!("there is no webloop at {path}; run cargo build"));
    }
    let doctor = Command::new(webloop).arg("doctor").output().unwrap();
    match doctor.status.code() {
        Some(0) => None,
        _ => Some(format!(
            "this machine cannot make a run:\n{}",
            String::from_utf8_lossy(&doctor.stdout)
        )),
    }
}

fn tests() -> Vec<Trial> {
    serial::tests![table::a_table_has_each_contender_or_says_why_not]
}

fn main() -> ExitCode {
    serial::run(tests(), lack)
}
