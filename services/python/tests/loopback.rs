//! The loop over loopback: the controller in Python as this crate starts it, and
//! the plant of this project. Few tests, one after another, with bounds that a
//! busy machine keeps.

use std::{
    io::{BufRead, BufReader},
    net::SocketAddr,
    path::Path,
    process::{Child, Command, ExitCode, ExitStatus, Stdio},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use control::preset;
use endpoint::{Counts, Lease, MessageOutcome, MessageRow, PlantSettings, SampleTime, TickRow};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tokio::sync::oneshot;

const MS: u64 = 1_000_000;

/// Long enough for anything here on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// What this test program becomes when it is started with these arguments, a
/// line each: `python::run` does not come back.
const ARGUMENTS: &str = "WEBLOOP_TEST_ARGUMENTS";

fn main() -> ExitCode {
    if let Ok(arguments) = std::env::var(ARGUMENTS) {
        let Err(error) = python::run(arguments.lines(), "");
        eprintln!("{error}");
        return ExitCode::from(match error {
            python::Error::Unsupported { .. } => 3,
            _ => 1,
        });
    }
    let tests = serial::tests![
        it_claims_a_plant_whose_lease_is_a_token_and_gives_it_back,
        the_loop_settles_on_both_schedules_blocking_and_not,
        a_controller_that_is_told_to_end_keeps_its_rows,
        what_is_wrong_is_said_with_its_exit_code,
    ];
    serial::run(tests, || {
        python::version().err().map(|error| error.to_string())
    })
}

fn controller(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this test"));
    command
        .env(ARGUMENTS, arguments.join("\n"))
        .stdin(Stdio::null());
    command
}

/// Waits for a child, and ends it if it takes too long.
fn wait(child: &mut Child) -> ExitStatus {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(status) = child.try_wait().expect("a child of ours") {
            return status;
        }
        thread::sleep(Duration::from_millis(10));
    }
    let _ = child.kill();
    panic!("the controller does not end: {:?}", child.wait());
}

fn h() -> SampleTime {
    SampleTime::try_new(3 * MS).expect("3 ms")
}

/// Runs a plant of h = 3 ms while `client` does.
fn with_plant<T>(out: &Path, client: impl FnOnce(SocketAddr) -> T) -> (T, endpoint::report::Plant) {
    with_settings(out, PlantSettings::new(h()), client)
}

/// Runs a plant with these settings while `client` does.
fn with_settings<T>(
    out: &Path,
    settings: PlantSettings,
    client: impl FnOnce(SocketAddr) -> T,
) -> (T, endpoint::report::Plant) {
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
    let facts = is_ready.recv_timeout(PATIENCE).expect("the plant starts");
    let result = client(facts.address);
    drop(stop);
    let report = plant.join().expect("no panic").expect("no errors");
    (result, report)
}

fn rows<R: serde::de::DeserializeOwned>(path: &Path) -> Vec<R> {
    let mut reader = csv::Reader::from_path(path).expect("the file");
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("rows")
}

/// What the controller left, checked for what every run keeps.
struct Left {
    report: Value,
    counts: Counts,
    messages: Vec<MessageRow>,
}

impl Left {
    fn read(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("controller.json")).expect("a report");
        let report: Value = serde_json::from_str(&text).expect("JSON");
        let counts: Counts =
            serde_json::from_value(report["counts"].clone()).expect("the native words");
        let messages: Vec<MessageRow> = rows(&folder.join("messages.csv"));
        assert_eq!(counts.due, counts.sent + counts.missed);
        assert_eq!(
            counts.sent,
            counts.answered + counts.timeout + counts.failed
        );
        assert_eq!(report["rows"]["rows"], counts.due);
        assert_eq!(report["rows"]["overflow"], 0);
        let mut numbers: Vec<u64> = messages.iter().map(|row| row.seq).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..counts.due).collect::<Vec<_>>());
        for row in &messages {
            assert!(
                row.t_send_ns.is_none_or(|t_ns| t_ns >= row.t_due_ns),
                "never early: {row:?}"
            );
        }
        assert_eq!(report["client"], "python");
        Self {
            report,
            counts,
            messages,
        }
    }
}

fn it_claims_a_plant_whose_lease_is_a_token_and_gives_it_back() {
    for transport in ["http", "websocket"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = PlantSettings {
            lease: Lease::Token,
            ..PlantSettings::safe(h())
        };
        let (_, plant) = with_settings(folder.path(), settings, |address| {
            // One after the other: the first gives the plant back at its end.
            for name in ["first", "second"] {
                let out = folder.path().join(name);
                let (address, text) = (address.to_string(), out.display().to_string());
                let mut arguments = vec!["--plant", &address, "--out", &text, "--claim"];
                arguments.extend(["--duration", "600ms", "--transport", transport]);
                let status = wait(&mut controller(&arguments).spawn().expect("a child"));
                assert!(status.success(), "{transport}: {status}");
                let left = Left::read(&out);
                assert_eq!(left.report["first_failure"], Value::Null, "{transport}");
                assert_eq!(left.counts.answered, left.counts.sent, "{transport}");
            }
        });
        // A machine that stands still lets a message by a newer connection come first, and the older is stale.
        let stale = plant.refusals.get("stale").copied().unwrap_or_default();
        assert_eq!(
            (plant.sessions, plant.refused),
            (2, stale),
            "{transport}: {plant:?}"
        );
        assert!(
            stale == 0 || transport == "http",
            "one connection keeps the order"
        );
    }
}

fn the_loop_settles_on_both_schedules_blocking_and_not() {
    for (schedule, outstanding) in [
        ("absolute", "unlimited"),
        ("absolute", "1"),
        ("relative", "unlimited"),
        ("relative", "1"),
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (status, plant) = with_plant(folder.path(), |address| {
            let out = folder.path().display().to_string();
            let address = address.to_string();
            let arguments = [
                "--plant",
                &address,
                "--out",
                &out,
                "--duration",
                "2400ms",
                "--schedule",
                schedule,
                "--outstanding",
                outstanding,
            ];
            wait(&mut controller(&arguments).spawn().expect("a child"))
        });
        let case = format!("{schedule}, {outstanding} outstanding");
        assert!(status.success(), "{case}: {status}");
        let left = Left::read(folder.path());
        assert_eq!(left.report["first_failure"], Value::Null, "{case}");
        assert_eq!(plant.arrivals, left.counts.sent, "{case}");
        if schedule == "absolute" {
            assert_eq!(left.counts.due, 800, "{case}");
        }
        // Without a network the loop settles to 2 % well within half a second;
        // over the last second only a stall of the machine can move it.
        let stop_ns = left.report["stop_ns"].as_u64().expect("a time");
        let ticks: Vec<TickRow> = rows(&folder.path().join("ticks.csv"));
        let tail: Vec<f64> = ticks
            .iter()
            .filter(|row| (stop_ns - 1000 * MS..stop_ns).contains(&row.t_due_ns))
            .map(|row| row.y)
            .collect();
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        assert!((mean - 1.0).abs() < 0.02, "{case}: last second at {mean}");
        if outstanding == "1" {
            // One at a time: the next is sent after the one before has ended.
            let answered = |row: &&MessageRow| row.outcome == MessageOutcome::Answered;
            let sent: Vec<&MessageRow> = left.messages.iter().filter(answered).collect();
            let in_turn = |pair: &[&MessageRow]| pair[0].t_receive_ns <= pair[1].t_send_ns;
            assert!(sent.windows(2).all(in_turn), "{case}");
        }
    }
}

fn a_controller_that_is_told_to_end_keeps_its_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (status, _) = with_plant(folder.path(), |address| {
        let out = folder.path().display().to_string();
        let address = address.to_string();
        let mut child = controller(&[
            "--plant",
            &address,
            "--out",
            &out,
            "--duration",
            "10m",
            "--mode",
            "open",
        ])
        .stdout(Stdio::piped())
        .spawn()
        .expect("a child");
        let stdout = BufReader::new(child.stdout.take().expect("piped"));
        // The test harness speaks before the controller does.
        assert!(
            stdout
                .lines()
                .map_while(Result::ok)
                .any(|line| line == format!("ready http://{address}"))
        );
        let start = Instant::now();
        let messages = folder.path().join("messages.csv");
        while std::fs::read_to_string(&messages).map_or(0, |text| text.lines().count()) < 3 {
            assert!(start.elapsed() < PATIENCE, "no rows while it runs");
            thread::sleep(Duration::from_millis(20));
        }
        let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        kill_process(pid.expect("a process"), Signal::TERM).expect("it runs");
        wait(&mut child)
    });
    assert_eq!(status.code(), Some(130));
    let left = Left::read(folder.path());
    assert_eq!(left.report["interrupted"], true);
    assert!(left.counts.answered > 0);
}

fn what_is_wrong_is_said_with_its_exit_code() {
    let usage = controller(&["--h", "3"]).output().expect("a child");
    assert_eq!(usage.status.code(), Some(2));
    let said = String::from_utf8_lossy(&usage.stderr);
    assert!(said.contains("write it like 3ms"), "{said}");

    // An interpreter that is not there.
    let missing = controller(&[])
        .env("WEBLOOP_PYTHON", "/nonexistent/python3")
        .output()
        .expect("a child");
    assert_eq!(missing.status.code(), Some(3));
    let said = String::from_utf8_lossy(&missing.stderr);
    assert!(
        said.contains("/nonexistent/python3") && said.contains("3.9"),
        "{said}"
    );

    // Rows of an earlier run are kept.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let messages = folder.path().join("messages.csv");
    std::fs::write(&messages, "rows\n").expect("a writable folder");
    let out = folder.path().display().to_string();
    let refused = controller(&["--out", &out]).output().expect("a child");
    assert_eq!(refused.status.code(), Some(1));
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("messages.csv"), "{said}");
    assert_eq!(
        std::fs::read_to_string(&messages).expect("the file"),
        "rows\n"
    );
}
