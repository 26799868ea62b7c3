//! The shaper on real packets, in real namespaces: as root, or in a user namespace.
//!
//! This test has a main of its own instead of the usual harness, for two reasons: only a
//! process with a single thread can enter a user namespace, and tests of time must not run
//! beside each other. It takes part of a test's name as argument, as the harness does.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod cell;
mod exactness;
mod lifetime;
mod traffic;

use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Instant;

use shaper::{Error, become_root};

type Test = (&'static str, fn());

const TESTS: &[Test] = &[
    (
        "a_constant_link_delays_each_way_by_its_delay",
        exactness::a_constant_link_delays_each_way_by_its_delay,
    ),
    (
        "each_of_the_paper_s_links_follows_its_prediction",
        exactness::each_of_the_paper_s_links_follows_its_prediction,
    ),
    (
        "a_stalling_link_follows_its_prediction_through_stalls_and_losses",
        exactness::a_stalling_link_follows_its_prediction_through_stalls_and_losses,
    ),
    (
        "a_missing_link_and_one_of_another_seed_are_found_out",
        exactness::a_missing_link_and_one_of_another_seed_are_found_out,
    ),
    (
        "loopback_needs_no_player",
        exactness::loopback_needs_no_player,
    ),
    (
        "a_tcp_transfer_arrives_intact_and_no_packet_is_lost_by_the_player",
        traffic::a_tcp_transfer_arrives_intact_and_no_packet_is_lost_by_the_player,
    ),
    (
        "a_burst_behind_a_stall_leaves_whole_and_in_order",
        traffic::a_burst_behind_a_stall_leaves_whole_and_in_order,
    ),
    (
        "an_unprivileged_user_can_play_a_link",
        lifetime::an_unprivileged_user_can_play_a_link,
    ),
    (
        "nothing_is_left_of_a_killed_process",
        lifetime::nothing_is_left_of_a_killed_process,
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
    if let [flag, role] = arguments.as_slice()
        && flag == lifetime::ROLE_FLAG
    {
        return lifetime::play_role(role);
    }
    match become_root() {
        Ok(authority) => println!("running as {authority:?}"),
        Err(error @ Error::Unsupported { .. }) => {
            println!("SKIPPED all tests of real namespaces: {error}");
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            println!("{error}");
            return ExitCode::FAILURE;
        }
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
        let passed = catch_unwind(*test).is_ok();
        failed += usize::from(!passed);
        let result = if passed { "ok" } else { "FAILED" };
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
