//! Services that are told to end during a run: each alone, and all of them.

use std::fs;
use std::process::Child;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use jiff::Timestamp;

use crate::docker::{docker, inspect};
use crate::testbed::{SERVICES, Testbed};
use crate::webloop::{column, said};

/// The limit that the issue sets.
const STOPPED_WITHIN: Duration = Duration::from_secs(2);

/// Time limit for `docker compose up` then: the agents are told, or hear nothing for half a minute.
const ENDED_WITHIN: Duration = Duration::from_secs(60);

/// Rows are written after a second at the latest, and copied once a second.
const ON_DISK_AFTER_NS: u64 = 2_500_000_000;

pub(crate) fn every_service_stops_soon_after_sigterm() -> Result<(), String> {
    for service in ["orchestrator", "plant", "controller-link"] {
        stops(&[service]);
    }
    stops(&SERVICES);
    println!(
        "row 22: each of 4 times told to end, every service ended within {STOPPED_WITHIN:?}, none was killed; its rows are on disk"
    );
    Ok(())
}

/// Sends SIGTERM to these services in the middle of a run.
fn stops(services: &[&str]) {
    let testbed = Testbed::new("diego-vpn", "20s");
    let mut up = testbed.up().spawn().unwrap();
    let cell = testbed.await_rows(&mut up);
    // Wait for a second of rows that have to be on disk.
    std::thread::sleep(Duration::from_secs(1));
    let containers: Vec<_> = services.iter().map(|s| testbed.container(s)).collect();
    let (signalled, signalled_ns) = (Timestamp::now(), now_ns());
    let mut kill = vec!["container", "kill", "--signal", "TERM"];
    kill.extend(containers.iter().map(String::as_str));
    docker(&kill).unwrap();
    for (service, container) in services.iter().zip(&containers) {
        let took = ended(container).duration_since(signalled);
        let state = &inspect(container)["State"];
        println!(
            "  {service} of {}: {:.2} s, {}",
            services.len(),
            took.as_secs_f64(),
            state["ExitCode"]
        );
        assert!(
            took <= STOPPED_WITHIN.try_into().unwrap(),
            "{service}: {took:#}"
        );
        assert_ne!(state["ExitCode"], 137, "{service} had to be killed");
    }
    let ticks = column(&fs::read(cell.join("ticks.csv")).unwrap(), "t_tick_ns");
    let last_ns: u64 = ticks.last().unwrap().parse().unwrap();
    let missing_ns = signalled_ns.saturating_sub(last_ns);
    assert!(
        missing_ns < ON_DISK_AFTER_NS,
        "rows end {missing_ns} ns before"
    );

    // If only an agent ends, its orchestrator notices after some time-outs; do not wait for that.
    if !services.contains(&"orchestrator") {
        testbed.down();
    }
    ends_badly(up);
    for container in testbed.containers() {
        let state = &inspect(&container)["State"];
        assert_ne!(state["ExitCode"], 137, "{container} had to be killed");
    }
}

/// When a container ended, by the engine's clock.
fn ended(container: &str) -> Timestamp {
    let deadline = Instant::now() + 10 * STOPPED_WITHIN;
    loop {
        let state = &inspect(container)["State"];
        if state["Running"] == false {
            return state["FinishedAt"].as_str().unwrap().parse().unwrap();
        }
        assert!(Instant::now() < deadline, "{container} still runs");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn ends_badly(mut up: Child) {
    let deadline = Instant::now() + ENDED_WITHIN;
    while up.try_wait().unwrap().is_none() {
        assert!(
            Instant::now() < deadline,
            "`docker compose up` does not end"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    let output = up.wait_with_output().unwrap();
    assert_ne!(output.status.code(), Some(0), "{}", said(&output));
}
