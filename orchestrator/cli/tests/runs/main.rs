//! The whole program: real processes, real namespaces, real signals.
//!
//! This test has a main of its own instead of the usual harness: what takes wall-clock time must
//! not run beside itself, and what a machine does not let us test is said and not swallowed. It
//! takes part of a test's name as argument, as the harness does.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod alone;
mod complete;
mod disk;
mod ending;
mod process;
mod unprivileged;
mod webloop;

use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Instant;

/// A test gives back why it could not be made on this machine, if so.
type Test = (&'static str, fn() -> Result<(), String>);

const TESTS: &[Test] = &[
    (
        "a_run_leaves_a_folder_that_proves_itself_and_is_not_made_twice",
        complete::a_run_leaves_a_folder_that_proves_itself_and_is_not_made_twice,
    ),
    (
        "an_unprivileged_user_can_run_and_leaves_nothing_when_killed",
        unprivileged::an_unprivileged_user_can_run_and_leaves_nothing_when_killed,
    ),
    (
        "of_two_runs_into_one_folder_one_runs",
        alone::of_two_runs_into_one_folder_one_runs,
    ),
    (
        "an_interrupted_run_ends_soon_with_its_rows",
        ending::an_interrupted_run_ends_soon_with_its_rows,
    ),
    (
        "a_killed_run_leaves_rows_and_nothing_else_and_can_be_continued",
        ending::a_killed_run_leaves_rows_and_nothing_else_and_can_be_continued,
    ),
    (
        "a_full_disk_is_told_and_the_run_is_made_once_there_is_space",
        disk::a_full_disk_is_told_and_the_run_is_made_once_there_is_space,
    ),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    if has("--ignored") {
        // None is.
        return ExitCode::SUCCESS;
    }
    if has("--list") {
        TESTS.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    if let Err(lack) = webloop::doctor(webloop::command()) {
        println!("SKIPPED all runs, because this machine cannot make one:\n{lack}");
        return ExitCode::SUCCESS;
    }
    let filters: Vec<&String> = arguments
        .iter()
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let mut failed = 0;
    for (name, test) in TESTS {
        if !filters.is_empty() && !filters.iter().any(|filter| name.contains(filter.as_str())) {
            continue;
        }
        println!("test {name} ...");
        let started = Instant::now();
        let result = match catch_unwind(*test) {
            Ok(Ok(())) => "ok".to_owned(),
            Ok(Err(lack)) => format!("SKIPPED: {lack}"),
            Err(_) => {
                failed += 1;
                "FAILED".to_owned()
            }
        };
        println!(
            "test {name} ... {result} ({:.1} s)",
            started.elapsed().as_secs_f64()
        );
    }
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        println!("{failed} failed");
        ExitCode::FAILURE
    }
}
