//! A plant whose controller goes wrong: divergence, a second controller, and what it says of it; `tests/silence.rs` has silence.

use std::{
    collections::BTreeMap,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
    thread,
    time::Duration,
};

use control::{Continuous, Method, Plant, TransferFunction};
use endpoint::{
    ArrivalRow, Lease, Model, Observation, PlantSettings, SampleTime, Signals, TickRow, checksum,
    report,
};
use plant::{Config, Ready};
use tokio_tungstenite::tungstenite::{Message, client};

use crate::{
    socket::closing,
    support::{
        Line, begin, config, connect_from, get, observe, rows, send, status, until, with_config,
        with_model,
    },
};

fn with(out: &Path, change: impl FnOnce(&mut PlantSettings)) -> Config {
    let mut config = config(out);
    config.settings = PlantSettings::new(SampleTime::try_new(1_000_000).expect("1 ms"));
    change(&mut config.settings);
    config
}

/// A pendulum on its head: y'' = 9 y + u.
fn pendulum(config: &Config) -> impl Model + Send + use<> {
    let model = TransferFunction::try_new([1.0], [1.0, 0.0, -9.0], Continuous).expect("valid");
    let plant = Plant::new(&model, Method::ZeroOrderHold);
    let sampled = plant.sampled(config.settings.h.ns());
    sampled.expect("it can be sampled").stepper()
}

#[test]
fn a_plant_that_left_the_finite_says_so_and_can_be_put_back_to_rest() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with(folder.path(), |settings| settings.lease = Lease::Address);
    let model = pendulum(&config);
    let report = with_model(config, model, |Ready { address, .. }| {
        let mut line = Line::open(address);
        let mut other = Line::open_from(2, address);
        assert_eq!(line.get("/closed?u=1e308&seq=9", "").0, 200);
        until("it diverges", || line.get("/state", "").0 == 500);
        let (status, words) = line.get("/health", "");
        assert_eq!(status, 503);
        assert!(
            words.contains("the loop has diverged; POST /reset"),
            "{words}"
        );
        let (status, words) = line.get("/closed?u=0&seq=10", "");
        assert_eq!(status, 500, "{words}");

        // Whoever is in control resets it, and nobody else.
        assert_eq!(other.get("/closed?u=0", "").0, 409);
        assert_eq!(other.request("POST /reset", "").0, 409);
        assert_eq!(line.request("POST /reset?u=1", "").0, 400);
        assert_eq!(line.request("GET /reset", "").0, 405);
        let (status, words) = line.request("POST /reset", "");
        assert_eq!((status, words.as_str()), (204, ""));
        let state = observe(address);
        assert_eq!((state.u, state.y), (0.0.into(), 0.0.into()), "{state:?}");
        thread::sleep(Duration::from_millis(50));
        let later = observe(address);
        assert_eq!((later.y, later.u_applied), (0.0.into(), 0.0.into()));
        assert!(later.tick > state.tick, "the ticks go on");
        assert_eq!(line.get("/health", "").0, 200);
        // Its controller may count from 0 again.
        assert_eq!(line.get("/closed?u=0.1&seq=0", "").0, 200);
        line.wait_for("it acts", |state| state.u_applied == 0.1);
    })
    .expect("a run without errors");
    assert!(report.refusals["diverged"] >= 2, "{report:?}");
    assert_eq!((report.refusals["lease"], report.refusals["query"]), (2, 1));
    let ticks: Vec<TickRow> = rows(&folder.path().join("ticks.csv"));
    assert_eq!(ticks.len() as u64, report.ticks);
    assert!(ticks.iter().any(|row| !row.y.is_finite()));
    assert!(
        ticks
            .last()
            .is_some_and(|row| row.y.is_finite() && row.u == 0.1)
    );
}

/// A plant that cannot be put back, as a program of one's own.
struct Tank;

impl Model for Tank {
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        u
    }
}

#[test]
fn a_plant_that_cannot_be_put_back_to_rest_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_model(config(folder.path()), Tank, |Ready { address, .. }| {
        let refused = send(address, "POST /reset", &[], "");
        assert_eq!(refused.status, 501, "{refused:?}");
        assert!(refused.body.contains("start it again"), "{refused:?}");
    })
    .expect("a run without errors");
}

#[test]
fn one_address_commands_at_a_time_over_http_and_over_a_websocket() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with(folder.path(), |settings| {
        *settings = PlantSettings::safe(settings.h);
    });
    let report = with_config(config, |Ready { address, .. }| {
        let (mut first, mut second) = (Line::open(address), Line::open_from(2, address));
        assert_eq!(first.get("/closed?u=1&seq=100", "").0, 200);
        let (status, words) = second.get("/closed?u=2&seq=101", "");
        assert_eq!(status, 409, "{words}");
        assert!(words.contains("another address is in control"), "{words}");
        let stream = connect_from(2, address);
        let (mut socket, _) =
            client(format!("ws://{address}/socket?mode=closed"), stream).expect("a socket");
        socket.send(Message::text("u=2&seq=102")).expect("it reads");
        let (code, reason) = closing(&mut socket);
        assert_eq!(code, 1008, "{reason}");
        assert!(reason.contains("another address"), "{reason}");
        assert_eq!(observe(address).u, 1.0);
        // Reading is free, and a page has to wait as well.
        assert_eq!(second.get("/state", "").0, 200);
        assert_eq!(crate::support::claim(address, "a page").status, 409);
        // After its silence the other one is welcome, and counts from 0.
        until("the lease is over", || {
            second.get("/closed?u=3&seq=0", "").0 == 200
        });
        let state = observe(address);
        assert_eq!(state.u, 3.0);
        assert_eq!(first.get("/closed?u=1&seq=200", "").0, 409);
    })
    .expect("a run without errors");
    assert!(report.refusals["lease"] >= 3, "{report:?}");
    assert!(!report.refusals.contains_key("stale"), "{report:?}");
}

#[test]
fn of_five_controllers_that_want_the_plant_one_has_it() {
    let commands = if cfg!(debug_assertions) {
        10_000
    } else {
        100_000
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with(folder.path(), |settings| settings.lease = Lease::Address);
    let taken = [const { AtomicU64::new(0) }; 5];
    let report = with_config(config, |Ready { address, .. }| {
        thread::scope(|scope| {
            for (n, taken) in (1..).zip(&taken) {
                scope.spawn(move || {
                    let mut line = Line::open_from(n, address);
                    for _ in 0..commands / 5 {
                        let (status, _) = line.get(&format!("/closed?u={n}"), "");
                        taken.fetch_add(u64::from(status == 200), Ordering::Relaxed);
                    }
                });
            }
        });
    })
    .expect("a run without errors");
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join("arrivals.csv"));
    let taken = taken.map(AtomicU64::into_inner);
    assert_eq!(report.refusals["lease"] + arrivals.len() as u64, commands);
    for (n, taken) in (1..).zip(taken) {
        let own = arrivals.iter().filter(|row| row.u == f64::from(n)).count();
        assert_eq!(own as u64, taken);
    }
    // Who has it keeps it until it is silent for two seconds: no other's command comes between.
    let changes = arrivals.windows(2).filter(|pair| pair[0].u != pair[1].u);
    for pair in changes {
        let silent_ns = pair[1].t_arrive_ns - pair[0].t_arrive_ns;
        assert!(silent_ns >= 2_000_000_000, "{pair:?}");
    }
    println!(
        "row 19: 5 controllers, {commands} commands: {} of the one with the lease, 0 of others between them",
        arrivals.len()
    );
}

#[test]
fn with_the_lease_token_nobody_commands_without_a_session() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with(folder.path(), |settings| settings.lease = Lease::Token);
    let report = with_config(config, |Ready { address, .. }| {
        let mut line = Line::open(address);
        let (status, words) = line.get("/closed?u=1", "");
        assert_eq!(status, 409);
        assert!(words.contains("begin one with POST /session"), "{words}");
        assert_eq!(crate::socket::open(address, "mode=closed").err(), Some(409));
        // Nobody is in control, so anybody may put it back.
        assert_eq!(line.request("POST /reset", "").0, 204);
        let token = begin(address, "a controller");
        assert_eq!(line.get("/closed?u=1", &token).0, 200);
        assert_eq!(line.request("POST /reset", "").0, 409);
        assert_eq!(line.request("POST /reset", &token).0, 204);
        assert_eq!(status_commands(address), 1);
    })
    .expect("a run without errors");
    let counted = [("lease", 1), ("session", 2)];
    let counted = counted.map(|(kind, count)| (kind.to_owned(), count));
    assert_eq!(report.refusals, BTreeMap::from(counted));
}

fn status_commands(address: std::net::SocketAddr) -> u64 {
    status(address)["commands"].as_u64().expect("a number")
}

/// A controller that keeps its rows itself leaves no files at the plant.
#[test]
fn a_session_without_rows_has_no_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = with_config(config(folder.path()), |Ready { address, .. }| {
        let json = ("Content-Type", "application/json");
        let claim = r#"{"client":"a program","rows":false}"#;
        let grant = send(address, "POST /session", &[json], claim);
        assert_eq!(grant.status, 200, "{grant:?}");
        let grant: serde_json::Value = serde_json::from_str(&grant.body).expect("JSON");
        let token = grant["session"].as_str().expect("a token");
        let refused = crate::support::post_rows(address, token, 0, "0,5,,,,1,,,,,missed,\n");
        assert_eq!(refused.status, 409, "{refused:?}");
        assert_eq!(crate::support::end(address, token, "{}").status, 204);
    });
    let report = run.expect("a run without errors");
    assert_eq!((report.sessions, report.page_rows.rows), (1, 0));
    assert!(!folder.path().join("messages.csv").exists());
    assert!(!folder.path().join("page.json").exists());
}

#[test]
fn a_checksum_is_checked_where_it_is_given_and_the_answer_has_one_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_config(config(folder.path()), |Ready { address, .. }| {
        let mut line = Line::open(address);
        let (status, text) = line.get(&format!("/closed?{}", checksum::signed("u=1&seq=3")), "");
        assert_eq!(status, 200, "{text}");
        let (answer, _) = checksum::checked(&text, true).expect("the answer's checksum");
        assert!(answer.starts_with("seq=3&"), "{answer}");
        let (status, text) = line.get("/closed?u=2&seq=4&crc=00000000", "");
        assert_eq!(status, 400);
        assert!(
            text.contains("the message was altered on its way"),
            "{text}"
        );
        let (_, text) = line.get("/closed?u=1&seq=5", "");
        assert!(!text.contains("crc"), "{text}");
        assert_eq!(observe(address).u, 1.0);
        // JSON has none.
        let signed = checksum::signed("u=1&seq=6");
        let (_, json) = get(address, &format!("/closed?{signed}"), "application/json");
        assert!(json.starts_with("{\"seq\":6,"), "{json}");
    })
    .expect("a run without errors");
    assert_eq!(
        report.refusals,
        BTreeMap::from([("checksum".to_owned(), 1)])
    );
}

#[test]
fn every_refusal_is_counted_by_its_kind_and_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with(folder.path(), |settings| {
        settings.max_age_ns = Some(1_000_000_000);
    });
    let report: report::Plant = with_config(config, |Ready { address, .. }| {
        let status =
            |request: &str, headers: &[(&str, &str)]| send(address, request, headers, "").status;
        assert_eq!(status("GET /motor", &[]), 404);
        assert_eq!(status("DELETE /closed", &[]), 405);
        assert_eq!(status("GET /closed?u=x&t_send_ns=1", &[]), 400);
        assert_eq!(status("GET /closed?u=1", &[]), 400, "its age is not told");
        assert_eq!(status("GET /state", &[("Host", "another")]), 400);
        assert_eq!(status("GET /state", &[("Origin", "http://a.example")]), 403);
        assert_eq!(status("GET /state", &[("Content-Length", "1")]), 413);
        assert_eq!(status("GET /socket?mode=open", &[]), 426);
        assert_eq!(status("POST /session", &[]), 415);
        assert_eq!(
            get(address, "/health", "*/*").1,
            "ok\nrefused: body 2, host 1, method 1, origin 1, path 1, query 2, websocket 1\n"
        );
        let _: Observation = observe(address);
    })
    .expect("a run without errors");
    assert_eq!(report.refused, 9);
    assert_eq!(report.refusals.values().sum::<u64>(), report.refused);
}
