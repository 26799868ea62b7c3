//! Sweeps through the binary: the same folder whatever the jobs and however often it was
//! interrupted, and points that equal the cells of a run.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

const SWEEP: &str = "name = \"mine\"\nabout = \"A small one\"\n\
[sweep]\nduration = \"1s\"\nrepeats = 2\n\
rtt = \"11 from 0ms to 100ms\"\n\
jitter = [\"0ms\", \"5ms\"]\n\
outstanding = [\"unlimited\", \"1\"]\n\
h = \"3ms\"\n";

fn webloop(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args(arguments)
        .env_remove("RUST_LOG")
        .output();
    output.unwrap()
}

fn sweep(place: &Path, name: &str, more: &[&str]) -> Output {
    let file = place.join("mine.toml");
    fs::write(&file, SWEEP).unwrap();
    let out = place.join(name);
    let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
    webloop(&[&["run", file, "--progress", "plain", "--out", out], more].concat())
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file of a folder, by its path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                files.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    files
}

#[test]
fn the_folder_is_the_same_whatever_the_jobs_and_however_often_it_was_broken_off() {
    let place = tempfile::tempdir().unwrap();
    let whole = sweep(place.path(), "whole", &["--jobs", "1"]);
    assert_eq!(whole.status.code(), Some(0), "{}", said(&whole));
    let want = files(&place.path().join("whole"));
    assert!(want.contains_key("maps/settling.svg") && want.contains_key("margins.csv"));
    let rows = String::from_utf8_lossy(&want["points.csv"]).into_owned();
    assert_eq!(rows.lines().count(), 1 + 11 * 2 * 2 * 2);

    let three = sweep(place.path(), "three", &["--jobs", "3"]);
    assert_eq!(three.status.code(), Some(0));
    assert_eq!(files(&place.path().join("three")), want);

    // What a killed run leaves: rows in any order, the last of them torn.
    let broken = place.path().join("three/points.csv");
    let mut lines: Vec<&str> = rows.lines().collect();
    lines.truncate(40);
    lines[1..].reverse();
    fs::write(&broken, lines.join("\n") + "\n12,1,99").unwrap();
    let again = sweep(place.path(), "three", &[]);
    assert_eq!(again.status.code(), Some(0));
    let told = said(&again);
    assert!(
        told.contains("is cut off") && told.contains("39 others are there"),
        "{told}"
    );
    assert_eq!(files(&place.path().join("three")), want);
    assert_eq!(again.stdout.len(), three.stdout.len());
}

#[test]
fn a_folder_of_another_sweep_is_left_alone_and_damage_is_named() {
    let place = tempfile::tempdir().unwrap();
    let first = sweep(place.path(), "ran", &["--fix", "jitter=0ms"]);
    assert_eq!(first.status.code(), Some(0), "{}", said(&first));
    let before = files(&place.path().join("ran"));
    for (more, why) in [
        (&["--fix", "jitter=0ms", "--seed", "2"][..], "another plan"),
        (&[][..], "another plan"),
    ] {
        let refused = sweep(place.path(), "ran", more);
        assert_eq!(refused.status.code(), Some(2));
        let told = said(&refused);
        assert!(told.contains(why) && told.contains("--out"), "{told}");
    }
    assert_eq!(files(&place.path().join("ran")), before);

    let points = place.path().join("ran/points.csv");
    let text = fs::read_to_string(&points).unwrap();
    fs::write(&points, text.replacen("\n1,", "\n1000,", 1)).unwrap();
    let refused = sweep(place.path(), "ran", &["--fix", "jitter=0ms"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("points.csv:"), "{}", said(&refused));

    let others = place.path().join("others");
    fs::create_dir(&others).unwrap();
    fs::write(others.join("thesis.txt"), "mine").unwrap();
    let refused = sweep(place.path(), "others", &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        said(&refused).contains("has files in it and no plan.json"),
        "{}",
        said(&refused)
    );
}

#[test]
fn a_file_of_before_and_a_plan_make_the_same_rows_and_it_is_said_how_to_write_it() {
    let place = tempfile::tempdir().unwrap();
    let ran = sweep(place.path(), "ran", &[]);
    assert_eq!(ran.status.code(), Some(0), "{}", said(&ran));
    let old = "name = \"mine\"\nabout = \"A small one\"\nduration = \"1s\"\nrepeats = 2\n[axes]\n\
               rtt = { from = \"0ms\", to = \"100ms\", steps = 11 }\njitter = [\"0ms\", \"5ms\"]\n\
               outstanding = [\"unlimited\", \"1\"]\nh = \"3ms\"\n";
    let [file, again, moved] = ["old.toml", "again", "moved"].map(|name| place.path().join(name));
    fs::write(&file, old).unwrap();
    let paths = [&file, &again, &moved].map(|path| path.to_str().unwrap());
    let read = webloop(&["sweep", paths[0], "--out", paths[1]]);
    assert_eq!(read.status.code(), Some(0), "{}", said(&read));
    let told = said(&read);
    for words in ["[sweep]", "rtt = \"11 from 0ms to 100ms\"", "webloop run"] {
        assert!(told.contains(words), "{told}");
    }
    assert_eq!(files(&again), files(&place.path().join("ran")));
    let plan = again.join("plan.json");
    let elsewhere = webloop(&["run", plan.to_str().unwrap(), "--out", paths[2]]);
    assert_eq!(elsewhere.status.code(), Some(0), "{}", said(&elsewhere));
    assert_eq!(files(&moved), files(&again));
}

#[test]
fn a_sweep_is_refused_where_cells_are_asked_for() {
    let place = tempfile::tempdir().unwrap();
    let ran = sweep(place.path(), "ran", &["--fix", "rtt=5ms"]);
    assert_eq!(ran.status.code(), Some(0), "{}", said(&ran));
    let ran = place.path().join("ran");
    let ran = ran.to_str().unwrap();
    for arguments in [
        &["run", "margin", "--only", "x"][..],
        &["run", "margin", "--require", "holds"],
        &["run", "margin", "--backend", "compose"],
        &["run", "quick", "--fix", "h=1ms"],
        &["gate", "margin"],
        &["matrix", "margin"],
        &["show", ran],
        &["report", ran],
        &["sweep", "quick"],
    ] {
        let refused = webloop(arguments);
        let told = said(&refused);
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains("sweep"), "{arguments:?}: {told}");
    }
}

#[test]
fn an_interrupted_sweep_keeps_what_is_done() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("long.toml");
    let long = SWEEP.replace("11 from", "9999 from").replace("1s", "10s");
    fs::write(&file, long).unwrap();
    let out = place.path().join("long");
    let child = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args([
            "run",
            file.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let points = out.join("points.csv");
    let rows = || {
        fs::read_to_string(&points)
            .unwrap_or_default()
            .lines()
            .count()
    };
    let began = Instant::now();
    while rows() < 2 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let told = said(&output);
    assert!(
        told.contains("are kept") && told.contains("--out"),
        "{told}"
    );
    assert!(rows() >= 2);
}

#[test]
fn a_point_over_a_whole_link_is_the_cell_of_a_run_in_virtual_time() {
    let place = tempfile::tempdir().unwrap();
    let experiment = place.path().join("run.toml");
    fs::write(
        &experiment,
        "name = \"mine\"\n[[cells]]\ntopology = [\"arima\", \"couva\", \"diego-vpn\"]\n\
         client = [\"native\"]\nmode = \"closed\"\nh = [\"3ms\", \"1ms\"]\nduration = \"4s\"\n\
         repeats = 2\n",
    )
    .unwrap();
    let swept = place.path().join("sweep.toml");
    fs::write(
        &swept,
        "name = \"mine\"\n[sweep]\nduration = \"4s\"\nrepeats = 2\n\
         topology = [\"arima\", \"couva\", \"diego-vpn\"]\nh = [\"3ms\", \"1ms\"]\n",
    )
    .unwrap();
    let (ran, points) = (place.path().join("ran"), place.path().join("swept"));
    let paths = [&experiment, &ran, &swept, &points].map(|path| path.to_str().unwrap());
    let run = webloop(&["run", paths[0], "--backend", "sim", "--out", paths[1]]);
    assert_eq!(run.status.code(), Some(0), "{}", said(&run));
    let sweep = webloop(&["run", paths[2], "--out", paths[3]]);
    assert_eq!(sweep.status.code(), Some(0), "{}", said(&sweep));

    let of_run = table(&ran.join("summary.csv"));
    let of_sweep = table(&points.join("points.csv"));
    assert_eq!((of_run.len(), of_sweep.len()), (12, 12));
    for row in of_sweep {
        let h_ms = &row["h_ms"];
        let same = |cell: &&BTreeMap<String, String>| {
            cell["topology"] == row["topology"]
                && cell["repeat"] == row["repeat"]
                && number(&cell["h_ns"]) / 1e6 == number(h_ms)
        };
        let cell = of_run.iter().find(same).unwrap();
        for figure in ["settling_ms", "overshoot_pct", "rise_ms", "iae_s"] {
            let (of_cell, of_point) = (number(&cell[figure]), number(&row[figure]));
            let apart = (of_cell - of_point).abs() / of_cell.abs().max(1e-9);
            assert!(
                apart < 1e-6 || of_cell.is_nan() && of_point.is_nan(),
                "{figure}: {of_cell} {of_point} in {row:?}"
            );
        }
    }
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or(f64::NAN)
}

/// A CSV file's rows, by their columns.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let fields = columns.iter().zip(line.split(','));
            fields
                .map(|(c, f)| ((*c).to_owned(), f.to_owned()))
                .collect()
        })
        .collect()
}
