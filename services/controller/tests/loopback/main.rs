//! The loop over loopback: the controller, real sockets, real time. Few tests,
//! one after another, with bounds that a busy machine keeps.
//!
//! This test has a main function of its own: one that a busy machine spoils is made again. What all have in
//! common is here.

// `--nocapture` prints what docs/safe-plant.md quotes.
#![allow(clippy::print_stdout)]

mod answering;
mod datagram;
mod errors;
mod every;
mod http;
mod line;
mod outcome;
mod scripted;
mod session;
mod stall;
mod websocket;

use std::{net::SocketAddr, path::Path, process::ExitCode, sync::mpsc, thread, time::Duration};

use control::preset;
use controller::{Config, DriveError, drive_until};
use endpoint::{ControllerSettings, MessageRow, PlantSettings, Policy, SampleTime, report};
use tokio::sync::oneshot;

const MS: u64 = 1_000_000;

fn main() -> ExitCode {
    let tests = serial::tests![
        datagram::a_datagram_that_is_lost_is_a_message_without_an_answer,
        every::the_loop_settles_at_its_reference_by_every_transport,
        every::an_open_loop_is_acknowledged_by_every_transport,
        every::what_a_transport_cannot_do_is_said_before_the_run,
        every::a_plant_that_takes_no_datagrams_is_said,
        errors::no_bad_answer_is_used_and_each_is_counted,
        http::the_paper_s_loop_settles_at_its_reference_at_333_hz_and_1_khz,
        http::a_new_connection_for_each_message_is_a_new_connection_for_each_message,
        http::a_plant_that_goes_away_costs_its_messages_and_not_the_run,
        http::a_silent_plant_is_timeouts_and_a_full_client_misses,
        http::what_cannot_be_reached_or_is_no_address_is_named,
        http::a_controller_that_is_told_to_end_keeps_its_rows,
        line::the_plant_s_last_line_is_the_reason_and_the_next_command_connects_again,
        line::answers_in_any_order_and_empty_lines_between_them_are_taken,
        outcome::whatever_a_plant_says_each_message_has_its_end_and_a_failure_its_words,
        session::a_controller_claims_the_plant_and_gives_it_back,
        session::a_controller_that_is_not_told_to_claim_is_refused_every_message,
        stall::a_stall_is_in_what_messages_took_and_what_was_not_sent_is_counted,
        websocket::answers_belong_to_their_commands_in_any_order,
        websocket::an_answer_that_is_none_fails_all_under_way_and_the_next_command_connects_again,
        websocket::the_plant_s_reason_to_close_is_said,
        websocket::a_silent_socket_is_timeouts_and_stays_open,
        websocket::a_plant_that_comes_back_is_found_again,
        websocket::a_refusal_is_said,
        websocket::commands_wait_for_one_attempt_to_connect_and_each_by_its_own_timeout,
        websocket::a_websocket_with_a_connection_for_each_message_is_refused,
    ];
    serial::run(tests, || None)
}

fn h(ms: u64) -> SampleTime {
    SampleTime::try_new(ms * MS).expect("a valid sample time")
}

/// Runs a plant while `client` does.
fn with_plant<T>(
    out: &Path,
    h: SampleTime,
    client: impl FnOnce(SocketAddr) -> T,
) -> (T, report::Plant) {
    with_settings(out, PlantSettings::new(h), client)
}

/// Runs a plant with these settings while `client` does.
fn with_settings<T>(
    out: &Path,
    settings: PlantSettings,
    client: impl FnOnce(SocketAddr) -> T,
) -> (T, report::Plant) {
    let config = plant::Config {
        listen: "127.0.0.1:0".parse().expect("an address"),
        hosts: Vec::new(),
        settings,
        law: None,
        reference: None,
        out: out.to_owned(),
        again: false,
    };
    let motor = preset::paper_plant().sampled(config.settings.h.ns());
    let motor = motor.expect("it can be sampled").stepper();
    let (ready, is_ready) = mpsc::channel();
    let (stop, stopped) = oneshot::channel::<()>();
    let plant = thread::spawn(move || {
        let stopped = async {
            let _ = stopped.await;
            Ok(())
        };
        plant::serve_until(&config, motor, stopped, |facts| {
            ready.send(facts).expect("the test waits");
        })
    });
    let facts = is_ready
        .recv_timeout(Duration::from_secs(10))
        .expect("the plant starts");
    let result = client(facts.address);
    drop(stop);
    (
        result,
        plant
            .join()
            .expect("no panic")
            .expect("a plant without errors"),
    )
}

fn config(
    out: &Path,
    address: SocketAddr,
    settings: ControllerSettings,
    duration_ms: u64,
) -> Config {
    Config {
        plant: format!("http://{address}"),
        settings,
        claim: false,
        check: false,
        reference: None,
        law: preset::paper_pi().into(),
        start_ns: None,
        duration_ns: duration_ms * MS,
        connections: 2,
        out: out.to_owned(),
        again: false,
        scheduling: Policy::Fifo,
    }
}

/// In a thread of its own, since real-time scheduling stays with a thread.
fn drive(config: &Config) -> Result<report::Native, DriveError> {
    thread::scope(|scope| {
        let run = scope.spawn(|| drive_until(config, std::future::pending()));
        run.join().expect("no panic")
    })
}

fn rows<R: serde::de::DeserializeOwned>(path: &Path) -> Vec<R> {
    let mut reader = csv::Reader::from_path(path).expect("the file");
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("rows")
}

/// Checks what every run keeps, whatever happened in it.
fn check(report: &report::Native, messages: &[MessageRow], deadlines: u64) {
    let counts = report.counts;
    assert_eq!(counts.due, deadlines);
    assert_eq!(counts.due, counts.sent + counts.missed);
    assert_eq!(
        counts.sent,
        counts.answered + counts.timeout + counts.failed
    );
    assert_eq!((report.rows.rows, report.rows.overflow), (deadlines, 0));
    let mut numbers: Vec<u64> = messages.iter().map(|row| row.seq).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, (0..deadlines).collect::<Vec<_>>());
    for row in messages {
        assert!(
            row.t_send_ns.is_none_or(|t_ns| t_ns >= row.t_due_ns),
            "never early: {row:?}"
        );
    }
}
