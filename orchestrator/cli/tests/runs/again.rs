//! A plant or a controller that is killed in the middle of a run, and started again for the rest of it.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use clock::now::now_ns;
use endpoint::{ArrivalRow, MessageOutcome, MessageRow, TickRow};
use rustix::process::{Pid, Signal, kill_process};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::webloop::{code, command, said};

const H_NS: u64 = 5_000_000;
const DURATION_NS: u64 = 3_000_000_000;

/// From the start of a controller to its first deadline: Python needs a while.
const AHEAD_NS: u64 = 1_500_000_000;

pub(crate) fn a_role_that_is_killed_goes_on_in_its_second_life() -> Result<(), String> {
    lives("controller", "native");
    let python = python::version();
    if python.is_ok() {
        lives("python", "python");
    }
    python.map(drop).map_err(|problem| problem.to_string())
}

/// Kills plant and controller once each, with a pause after which they start again.
fn lives(role: &str, client: &str) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let plant = |listen: SocketAddr, again: bool| {
        let settings = json!({
            "listen": listen,
            "settings": endpoint::PlantSettings::new(h()),
            "again": again,
        });
        serve("plant", folder, &settings)
    };
    let (first_plant, ready) = plant("127.0.0.1:0".parse().unwrap(), false);
    let address: SocketAddr = ready.parse().unwrap();
    let start_ns = now_ns() + AHEAD_NS;
    let controller = |told: Value| {
        let mut settings = json!({
            "client": client,
            "plant": address,
            "settings": endpoint::ControllerSettings::new(endpoint::Mode::Closed, h()),
            "duration_ns": DURATION_NS,
        });
        settings
            .as_object_mut()
            .unwrap()
            .extend(told.as_object().unwrap().clone());
        serve(role, folder, &settings).0
    };
    let first_controller = controller(json!({ "start_ns": start_ns }));

    until(start_ns + 500_000_000);
    kill(first_plant);
    sleep(Duration::from_millis(200));
    let (second_plant, _) = plant(address, true);
    until(start_ns + 1_200_000_000);
    kill(first_controller);
    sleep(Duration::from_millis(200));
    let lost = controller(json!({ "again": true }))
        .wait_with_output()
        .unwrap();
    assert_eq!(code(&lost), Some(2), "{}", said(&lost));
    assert!(
        said(&lost).contains("without `start_ns`"),
        "{}",
        said(&lost)
    );
    let second_controller = controller(json!({ "start_ns": start_ns, "again": true }));
    let ended = second_controller.wait_with_output().unwrap();
    assert_eq!(code(&ended), Some(0), "{}", said(&ended));
    let ended = end(second_plant);
    assert_eq!(code(&ended), Some(0), "{}", said(&ended));

    let ticks: Vec<TickRow> = rows(&folder.join(TickRow::FILE), TickRow::COLUMNS);
    let report = report(&folder.join("plant.json"));
    let plant_start_ns = report["start_ns"].as_u64().unwrap();
    assert!(
        ticks
            .iter()
            .all(|row| row.t_due_ns == plant_start_ns + row.k * H_NS)
    );
    let gaps: Vec<u64> = ticks
        .windows(2)
        .map(|pair| pair[1].k - pair[0].k)
        .filter(|step| *step != 1)
        .collect();
    assert!(
        matches!(gaps[..], [gap] if gap > 200_000_000 / H_NS),
        "{client}: {gaps:?}"
    );
    assert!(
        report["ticks"].as_u64().unwrap() < ticks.len() as u64,
        "{report}"
    );

    let arrivals: Vec<ArrivalRow> = rows(&folder.join(ArrivalRow::FILE), ArrivalRow::COLUMNS);
    assert!((0..).zip(&arrivals).all(|(n, row)| row.n == n));

    let messages: Vec<MessageRow> = rows(&folder.join(MessageRow::FILE), MessageRow::COLUMNS);
    assert!(
        messages
            .iter()
            .all(|row| row.t_due_ns == start_ns + row.seq * H_NS)
    );
    // The rows are in the order in which messages ended, so sorted here.
    let seqs: BTreeSet<u64> = messages.iter().map(|row| row.seq).collect();
    assert_eq!(seqs.len(), messages.len(), "{client}: a number comes twice");
    assert_eq!(seqs.last(), Some(&(DURATION_NS / H_NS - 1)));
    let gap = seqs
        .iter()
        .zip(seqs.iter().skip(1))
        .map(|(a, b)| b - a)
        .max();
    assert!(gap > Some(200_000_000 / H_NS), "{client}: {gap:?}");
    let answered = |row: &&MessageRow| row.outcome == MessageOutcome::Answered;
    let last = messages
        .iter()
        .filter(answered)
        .map(|row| row.t_due_ns)
        .max();
    assert!(
        last > Some(start_ns + DURATION_NS * 9 / 10),
        "{client}: not heard to the end"
    );
}

fn h() -> endpoint::SampleTime {
    endpoint::SampleTime::try_new(H_NS).unwrap()
}

/// Starts a role, which is told its settings by standard input; what it says it is ready with.
fn serve(role: &str, folder: &Path, settings: &Value) -> (Child, String) {
    let mut command = command();
    command
        .args(["serve", role, "--settings", "-", "--out"])
        .arg(folder);
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(settings.to_string().as_bytes()).unwrap();
    drop(stdin);
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap())
        .read_line(&mut line)
        .unwrap();
    (
        child,
        line.trim_start_matches("ready ").trim_end().to_owned(),
    )
}

fn until(t_ns: u64) {
    sleep(Duration::from_nanos(t_ns.saturating_sub(now_ns())));
}

fn kill(mut child: Child) {
    assert!(
        child.try_wait().unwrap().is_none(),
        "it has ended by itself"
    );
    child.kill().unwrap();
    child.wait().unwrap();
}

fn end(child: Child) -> Output {
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    kill_process(pid.unwrap(), Signal::TERM).unwrap();
    child.wait_with_output().unwrap()
}

fn report(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// All rows of a file, of which none is torn.
fn rows<R: DeserializeOwned>(path: &Path, columns: &[&str]) -> Vec<R> {
    assert!(
        fs::read_to_string(path).unwrap().ends_with('\n'),
        "{path:?}"
    );
    let mut reader = csv::Reader::from_path(path).unwrap();
    assert_eq!(reader.headers().unwrap(), columns);
    reader.deserialize().map(|row| row.unwrap()).collect()
}
