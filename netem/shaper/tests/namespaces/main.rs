//! The shaper on real packets, in real namespaces: as root, or in a user namespace.
//!
//! This test has a main of its own instead of the usual harness, for two reasons: only a
//! process with a single thread can enter a user namespace, and tests of time must not run
//! beside each other. It takes part of a test's name as argument, as the harness does.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod attempt;
mod cell;
mod crossing;
mod exactness;
mod kernel;
mod lifetime;
mod tc;
mod traffic;
mod trap;
mod tunnel;

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
    (
        "each_link_holds_over_a_tunnel_too",
        crossing::each_link_holds_over_a_tunnel_too,
    ),
    (
        "a_tcp_transfer_crosses_a_tunnel_intact",
        crossing::a_tcp_transfer_crosses_a_tunnel_intact,
    ),
    (
        "a_burst_behind_a_stall_crosses_a_tunnel_whole_and_in_order",
        crossing::a_burst_behind_a_stall_crosses_a_tunnel_whole_and_in_order,
    ),
    (
        "a_stranger_s_datagram_is_not_let_in",
        crossing::a_stranger_s_datagram_is_not_let_in,
    ),
    (
        "without_the_capability_the_error_names_it",
        crossing::without_the_capability_the_error_names_it,
    ),
    (
        "a_second_player_beside_an_end_is_refused",
        crossing::a_second_player_beside_an_end_is_refused,
    ),
    (
        "nothing_is_left_of_a_killed_player_beside_an_end",
        crossing::nothing_is_left_of_a_killed_player_beside_an_end,
    ),
    (
        "a_tunnel_can_be_played_in_a_user_namespace",
        crossing::a_tunnel_can_be_played_in_a_user_namespace,
    ),
    (
        "tc_plays_each_of_the_paper_s_links_as_predicted",
        tc::tc_plays_each_of_the_paper_s_links_as_predicted,
    ),
    (
        "tc_keeps_order_when_the_delay_falls_unless_it_is_free",
        trap::tc_keeps_order_when_the_delay_falls_unless_it_is_free,
    ),
    (
        "tc_loses_nothing_in_a_stall_at_1_khz_both_ways",
        trap::tc_loses_nothing_in_a_stall_at_1_khz_both_ways,
    ),
    (
        "tc_does_not_shape_the_first_packet_s_arp",
        trap::tc_does_not_shape_the_first_packet_s_arp,
    ),
    (
        "tc_leaves_a_foreign_qdisc_alone",
        trap::tc_leaves_a_foreign_qdisc_alone,
    ),
    (
        "tc_notices_what_the_kernel_plays_and_restores_what_it_found",
        trap::tc_notices_what_the_kernel_plays_and_restores_what_it_found,
    ),
    (
        "tc_changes_keep_the_packets_that_are_under_way",
        trap::tc_changes_keep_the_packets_that_are_under_way,
    ),
    (
        "tc_plays_a_delay_of_seconds",
        trap::tc_plays_a_delay_of_seconds,
    ),
    (
        "tc_switches_loss_on_and_off",
        trap::tc_switches_loss_on_and_off,
    ),
    (
        "tc_limits_the_rate_of_ip_packets",
        trap::tc_limits_the_rate_of_ip_packets,
    ),
    (
        "tc_gets_single_packets_from_tcp",
        trap::tc_gets_single_packets_from_tcp,
    ),
    (
        "tc_says_what_is_missing_and_what_to_do",
        trap::tc_says_what_is_missing_and_what_to_do,
    ),
    ("tc_can_be_stopped_at_once", trap::tc_can_be_stopped_at_once),
    (
        "what_needs_netem_holds_in_a_kernel_that_has_it",
        kernel::what_needs_netem_holds_in_a_kernel_that_has_it,
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
