//! The whole program: real processes, real namespaces, real signals.
//!
//! This test has a main function of its own instead of the usual harness: tests that take
//! wall-clock time must not run at the same time, and tests that the machine does not allow are
//! reported as skipped.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod again;
mod alarm;
mod alone;
mod attempt;
mod cheat;
mod clients;
mod clock;
mod complete;
mod continued;
mod decoy;
mod disk;
mod ending;
mod hit;
mod matrix;
mod own;
mod own_plant;
mod process;
mod stranger;
mod stray;
mod unprivileged;
mod webloop;

use std::process::ExitCode;

use serial::Trial;

fn tests() -> Vec<Trial> {
    serial::tests![
        complete::a_run_leaves_a_folder_that_proves_itself_and_is_not_made_twice,
        unprivileged::an_unprivileged_user_can_run_and_leaves_nothing_when_killed,
        alarm::undisturbed_runs_raise_no_alarm,
        again::a_role_that_is_killed_goes_on_in_its_second_life,
        stranger::honest_programs_are_not_called_cheats,
        alone::of_two_runs_into_one_folder_one_runs,
        clock::a_wall_clock_that_steps_moves_nothing,
        matrix::jobs_of_one_plan_merge_by_being_copied,
        clients::every_client_closes_the_loop_over_a_link,
        clients::every_client_runs_a_law_that_is_not_the_paper_s_to_the_last_bit,
        clients::a_browser_that_fails_is_told_by_the_name_of_its_failure,
        clients::a_killed_run_takes_its_browser_with_it,
        own::a_controller_that_breaks_the_contract_fails_by_name_and_leaves_nothing,
        own::the_examples_hold_the_loop_and_keep_the_contract,
        own::conformance_names_each_planted_fault,
        attempt::a_stranger_s_controller_gets_its_answer_by_one_line_which_is_an_experiment,
        attempt::a_stranger_s_plant_runs_by_one_line_in_virtual_time_too,
        cheat::a_program_of_one_s_own_reaches_no_rows_no_process_and_no_engine,
        cheat::a_program_that_ends_with_127_makes_the_run_unsupported,
        own_plant::a_motor_of_one_s_own_equals_the_built_in_one,
        own_plant::a_pendulum_of_one_s_own_is_held_over_a_link,
        own_plant::two_inputs_and_outputs_are_held_over_a_link_and_in_virtual_time,
        own_plant::a_plant_that_starts_slowly_is_waited_for,
        own_plant::a_plant_that_breaks_its_contract_fails_by_name_and_leaves_nothing,
        ending::an_interrupted_run_ends_soon_with_its_rows,
        ending::a_killed_run_leaves_rows_and_nothing_else_and_can_be_continued,
        continued::a_campaign_goes_on_where_it_was_broken_off_and_only_what_failed_is_made_again,
        hit::a_fault_of_an_end_is_done_as_asked,
        stray::a_fault_that_was_asked_for_hides_no_other,
        disk::a_full_disk_is_told_and_the_run_is_made_once_there_is_space,
    ]
}

fn main() -> ExitCode {
    serial::run(tests(), || {
        let lack = webloop::doctor(webloop::command()).err()?;
        Some(format!("this machine cannot make a run:\n{lack}"))
    })
}
