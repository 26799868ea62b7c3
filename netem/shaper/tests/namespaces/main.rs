//! The shaper on real packets, in real namespaces: as root, or in a user namespace.
//!
//! This test has a main of its own instead of the usual harness, for two reasons: only a
//! process with a single thread can enter a user namespace, and tests of time must not run
//! beside each other.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod attempt;
mod cell;
mod crossing;
mod exactness;
mod fault;
mod kernel;
mod lifetime;
mod tc;
mod traffic;
mod trap;
mod tunnel;

use std::process::ExitCode;

use serial::Trial;
use shaper::{Error, become_root};

fn tests() -> Vec<Trial> {
    serial::tests![
        exactness::a_constant_link_delays_each_way_by_its_delay,
        exactness::each_of_the_paper_s_links_follows_its_prediction,
        exactness::a_stalling_link_follows_its_prediction_through_stalls_and_losses,
        exactness::a_missing_link_and_one_of_another_seed_are_found_out,
        exactness::loopback_needs_no_player,
        traffic::a_tcp_transfer_arrives_intact_and_no_packet_is_lost_by_the_player,
        traffic::segments_cross_whole_where_a_link_treats_packets_alike,
        traffic::single_packets_cross_a_link_with_a_rate,
        traffic::a_burst_behind_a_stall_leaves_whole_and_in_order,
        fault::echoes_prove_a_link_with_each_fault,
        fault::duplicates_come_out_twice_and_do_tcp_no_harm,
        fault::a_flipped_bit_never_reaches_a_program_and_is_sent_again,
        fault::packets_that_are_held_back_are_overtaken_and_tcp_puts_them_in_order,
        fault::a_reset_ends_the_connection_under_way_and_another_can_be_opened,
        fault::a_changed_port_ends_old_connections_and_lets_new_ones_work,
        fault::a_link_that_is_down_carries_nothing_until_it_is_up_again,
        lifetime::an_unprivileged_user_can_play_a_link,
        lifetime::nothing_is_left_of_a_killed_process,
        crossing::each_link_holds_over_a_tunnel_too,
        crossing::a_tcp_transfer_crosses_a_tunnel_intact,
        crossing::a_burst_behind_a_stall_crosses_a_tunnel_whole_and_in_order,
        crossing::a_stranger_s_datagram_is_not_let_in,
        crossing::malformed_packets_are_counted_and_disturb_nothing,
        crossing::without_the_capability_the_error_names_it,
        crossing::a_second_player_beside_an_end_is_refused,
        crossing::nothing_is_left_of_a_killed_player_beside_an_end,
        crossing::a_tunnel_can_be_played_in_a_user_namespace,
        tc::tc_plays_each_of_the_paper_s_links_as_predicted,
        trap::tc_keeps_order_when_the_delay_falls_unless_it_is_free,
        trap::tc_loses_nothing_in_a_stall_at_1_khz_both_ways,
        trap::tc_does_not_shape_the_first_packet_s_arp,
        trap::tc_leaves_a_foreign_qdisc_alone,
        trap::tc_notices_what_the_kernel_plays_and_restores_what_it_found,
        trap::tc_changes_keep_the_packets_that_are_under_way,
        trap::tc_plays_a_delay_of_seconds,
        trap::tc_switches_loss_on_and_off,
        trap::tc_limits_the_rate_of_ip_packets,
        trap::tc_gets_single_packets_from_tcp,
        trap::tc_says_what_is_missing_and_what_to_do,
        trap::tc_can_be_stopped_at_once,
        kernel::what_needs_netem_holds_in_a_kernel_that_has_it,
    ]
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, role] = arguments.as_slice()
        && flag == lifetime::ROLE_FLAG
    {
        return lifetime::play_role(role);
    }
    serial::run(tests(), || match become_root() {
        Ok(authority) => {
            println!("running as {authority:?}");
            None
        }
        Err(error @ Error::Unsupported { .. }) => Some(error.to_string()),
        Err(error) => panic!("{error}"),
    })
}
