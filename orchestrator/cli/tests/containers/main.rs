//! The whole testbed in real containers, from the images that `docker compose build` made.
//!
//! This test has a main function of its own instead of the usual harness: tests that take
//! wall-clock time must not run at the same time, and tests that the machine does not allow are
//! reported as skipped. It builds no images, which takes minutes: `.ci/run` does that first; by
//! hand, run `docker compose build` after each change.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod arms;
mod clients;
mod docker;
mod guest;
mod killed;
mod own;
mod refused;
mod stopped;
mod stopping;
mod testbed;
mod up;
// What a fault of an end does, shared with the tests of runs in namespaces.
#[path = "../runs/hit.rs"]
mod hit;
// The program and its folders, shared with the tests of runs in namespaces.
#[allow(dead_code)]
#[path = "../runs/webloop.rs"]
mod webloop;

use std::process::ExitCode;

use serial::Trial;

fn tests() -> Vec<Trial> {
    serial::tests![
        up::up_ends_by_itself_with_results_of_their_folders_owner,
        refused::what_up_cannot_do_it_says_in_a_line_and_ends,
        refused::what_run_cannot_do_in_containers_it_says_with_its_code,
        clients::each_client_runs_in_a_container_through_a_shaped_link,
        own::every_example_holds_the_loop_in_a_container,
        own::an_image_is_held_against_the_contract,
        own::a_plant_of_ones_own_runs_in_a_container_on_a_link_and_on_loopback,
        own::one_that_does_not_end_fails_by_name_and_the_next_is_complete,
        stopped::a_client_that_is_stopped_in_its_container_is_told_by_that_name,
        hit::a_fault_of_an_end_is_done_in_containers_too,
        stopping::every_service_stops_soon_after_sigterm,
        killed::a_run_that_is_told_to_end_takes_its_containers_with_it,
        killed::what_a_killed_run_leaves_is_swept_and_nothing_else,
        arms::the_same_cell_gives_the_same_in_namespaces_in_containers_and_by_tc,
    ]
}

fn main() -> ExitCode {
    serial::run(tests(), docker::lack)
}
