//! It measures for real, and names what it cannot measure. How fast anything is, no test says.

use std::fs;
use std::process::{Command, Output, Stdio};

use crate::BENCH;

pub(crate) fn a_table_has_each_contender_or_says_why_not() {
    const CONTENDERS: [(&str, &[&str]); 4] = [
        (
            "step",
            &[
                "TCP echo",
                "webloop, WebSocket",
                "webloop, HTTP",
                "hyper",
                "reqwest",
                "wrk",
                "oha",
            ],
        ),
        (
            "tick",
            &[
                "cyclictest, FIFO",
                "webloop, plant",
                "tokio interval",
                "Python sleep",
            ],
        ),
        (
            "delay",
            &[
                "veth alone, no delay",
                "webloop",
                "kernel netem",
                "Rattan",
                "webloop, 100 Hz",
            ],
        ),
        ("stream", &["veth alone", "webloop", "Rattan"]),
    ];
    /// What every machine of a run has.
    const MEASURED: [&str; 4] = ["TCP echo", "webloop, HTTP", "webloop, plant", "veth alone"];
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bench");
    let bench = || {
        Command::new(BENCH)
            .args(CONTENDERS.map(|(table, _)| table))
            .args(["--times", "2", "--measure-ms", "100", "--out"])
            .arg(&out)
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .output()
            .unwrap()
    };
    let output = bench();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let values = fs::read_to_string(out.join("bench.csv")).unwrap();
    for (table, contenders) in CONTENDERS {
        for contender in contenders {
            let line = printed.lines().find(|line| {
                line.get(9..)
                    .is_some_and(|rest| rest.starts_with(contender))
            });
            let is_skipped = line.unwrap_or_default().contains("skipped: ");
            let is_measured = values.contains(&format!("\n{table},\"{contender}\","));
            assert!(is_skipped != is_measured, "{contender}: {printed}");
            assert!(is_measured || !MEASURED.contains(contender), "{printed}");
        }
    }
    // Each repetition is in the file, and its ratio to itself is one.
    let echo = values
        .lines()
        .filter(|line| line.starts_with("step,\"TCP echo\",limit,p50_us,"));
    assert_eq!(echo.count(), 2, "{values}");
    assert!(printed.contains("1.00 (1.00 to 1.00)"), "{printed}");
    for file in ["bench.txt", "machine.json"] {
        assert!(out.join(file).exists(), "{file}");
    }
    // Figures of another machine or day are not mixed with these.
    let again = bench();
    assert_eq!(again.status.code(), Some(2), "{}", said(&again));
}

/// What it says to people.
fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
