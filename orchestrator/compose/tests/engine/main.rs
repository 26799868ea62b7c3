//! The whole crate against a real container engine: what it makes, and what it leaves alone.
//!
//! This test has a main of its own instead of the usual harness: it changes what the engine
//! holds, so nothing may run beside it, and a machine without an engine is said and not
//! swallowed. Every name that it makes holds this process's number, and it sweeps no project
//! but its own. It takes part of a test's name as argument, as the harness does.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod campaign;
mod docker;
mod hardening;
mod sweep;

use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Instant;

const TESTS: &[(&str, fn())] = &[
    (
        "no_service_is_given_more_than_it_needs",
        hardening::no_service_is_given_more_than_it_needs,
    ),
    (
        "settings_come_from_the_environment",
        hardening::settings_come_from_the_environment,
    ),
    (
        "an_old_compose_is_told_what_it_takes",
        hardening::an_old_compose_is_told_what_it_takes,
    ),
    (
        "a_sweep_takes_what_nobody_uses_and_nothing_else",
        sweep::a_sweep_takes_what_nobody_uses_and_nothing_else,
    ),
    (
        "cells_end_with_their_code_and_leave_rows_of_the_folders_owner",
        campaign::cells_end_with_their_code_and_leave_rows_of_the_folders_owner,
    ),
    (
        "cells_that_are_told_to_end_do_so",
        campaign::cells_that_are_told_to_end_do_so,
    ),
    (
        "an_agent_that_does_not_start_is_quoted",
        campaign::an_agent_that_does_not_start_is_quoted,
    ),
    (
        "what_a_killed_campaign_left_is_swept",
        campaign::what_a_killed_campaign_left_is_swept,
    ),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, folder] = &arguments[..]
        && word == campaign::CHILD
    {
        campaign::run_until_killed(folder.as_ref());
        return ExitCode::SUCCESS;
    }
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    if has("--ignored") {
        // None is.
        return ExitCode::SUCCESS;
    }
    if has("--list") {
        TESTS.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    if let Err(lack) = compose::serves().and(compose::composes()) {
        println!("SKIPPED all that need a container engine: {lack}");
        return ExitCode::SUCCESS;
    }
    let image = match docker::Image::build() {
        Ok(image) => image,
        Err(lack) => {
            println!("SKIPPED all that need a container engine: no image to try it with: {lack}");
            return ExitCode::SUCCESS;
        }
    };
    let filters: Vec<&String> = arguments
        .iter()
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let mut failed = 0;
    for (name, test) in TESTS {
        if !filters.is_empty() && !filters.iter().any(|filter| name.contains(filter.as_str())) {
            continue;
        }
        let started = Instant::now();
        let result = if catch_unwind(test).is_ok() {
            "ok"
        } else {
            "FAILED"
        };
        failed += u32::from(result == "FAILED");
        println!(
            "test {name} ... {result} ({:.1} s)",
            started.elapsed().as_secs_f64()
        );
    }
    drop(image);
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        println!("{failed} failed");
        ExitCode::FAILURE
    }
}
