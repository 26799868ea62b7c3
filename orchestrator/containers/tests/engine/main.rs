//! The whole crate against a real container engine: what it makes, and what it leaves alone.
//!
//! This test has a main of its own instead of the usual harness: it changes what the engine
//! holds, so nothing may run beside it, and a machine without an engine is said and not
//! swallowed. Every name that it makes holds this process's number, and it sweeps no project
//! but its own.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod campaign;
mod docker;
mod hardening;
mod sweep;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, folder] = &arguments[..]
        && word == campaign::CHILD
    {
        campaign::run_until_killed(folder.as_ref());
        return ExitCode::SUCCESS;
    }
    let tests = serial::tests![
        hardening::no_service_is_given_more_than_it_needs,
        hardening::settings_come_from_the_environment,
        hardening::an_old_compose_is_told_what_it_takes,
        sweep::a_sweep_takes_what_nobody_uses_and_nothing_else,
        campaign::cells_end_with_their_code_and_leave_rows_of_the_folders_owner,
        campaign::cells_that_are_told_to_end_do_so,
        campaign::an_agent_that_does_not_start_is_quoted,
        campaign::what_a_killed_campaign_left_is_swept,
    ];
    let mut image = None;
    let code = serial::run(tests, || {
        let ready = containers::compose::serves().and(containers::compose::composes());
        let lack = match ready
            .map_err(|lack| lack.to_string())
            .and_then(|_| docker::Image::build())
        {
            Ok(built) => {
                image = Some(built);
                return None;
            }
            Err(lack) => lack,
        };
        Some(format!(
            "they need a container engine and an image to try it with: {lack}"
        ))
    });
    drop(image);
    code
}
