//! The wall clock steps by an hour during a run, either way: no row and no figure follows it.
//!
//! libfaketime is the clock of each process of the run, and leaves the monotonic one alone.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::Duration;

use plan::Verdict;

use crate::ending::await_rows;
use crate::webloop::{Experiment, code, column, command, manifest, said, too_busy, was_busy};

const LIBRARY: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1";

/// 2 s at h = 3 ms.
const H_NS: i64 = 3_000_000;

pub(crate) fn a_wall_clock_that_steps_moves_nothing() -> Result<(), String> {
    if !Path::new(LIBRARY).exists() {
        return Err(format!("there is no {LIBRARY}; install faketime"));
    }
    for step in ["+1h", "-1h"] {
        stepped(step)?;
    }
    println!(
        "row 25: the wall clock stepped by an hour, forward and back: no time before another, every deadline a sample time after the last, to the nanosecond"
    );
    Ok(())
}

fn stepped(step: &str) -> Result<(), String> {
    for _ in serial::tries() {
        let folder = tempfile::tempdir().unwrap();
        let offset = folder.path().join("offset");
        fs::write(&offset, "+0").unwrap();
        let experiment = Experiment::new(folder.path(), &["office"], "3ms", "2s");
        let mut run = under(experiment.run(command()), &offset).spawn().unwrap();
        await_rows(&mut run, &experiment);
        fs::write(&offset, step).unwrap();
        assert!(unix_s(&offset).abs_diff(unix_s(Path::new("/dev/null"))) > 3_500);
        thread::sleep(Duration::from_millis(500));
        fs::write(&offset, "+0").unwrap();
        let output = run.wait_with_output().unwrap();
        let cell = &experiment.cells()[0];
        let manifest = manifest(cell);
        if was_busy(&manifest) {
            println!("  too busy: {:?}", manifest.reasons);
            continue;
        }
        assert_eq!(code(&output), Some(0), "{step}: {}", said(&output));
        assert_eq!(manifest.verdict, Verdict::Complete);
        check(cell);
        return Ok(());
    }
    Err(too_busy("this run"))
}

/// The command with a wall clock that is off by what this file says.
fn under(mut command: Command, offset: &Path) -> Command {
    command
        .env("LD_PRELOAD", LIBRARY)
        .env("FAKETIME_TIMESTAMP_FILE", offset)
        .env("FAKETIME_NO_CACHE", "1")
        .env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
    command
}

/// The wall clock of a program under such a clock, s.
fn unix_s(offset: &Path) -> i64 {
    let mut date = Command::new("date");
    date.arg("+%s");
    let output = under(date, offset).output().unwrap();
    String::from_utf8_lossy(&output.stdout)
        .trim()
        .parse()
        .unwrap()
}

/// Deadlines and ticks are h apart, and nothing comes before its cause.
fn check(cell: &Path) {
    let times = |file: &str, name: &str| -> Vec<i64> {
        let column = column(&fs::read(cell.join(file)).unwrap(), name);
        column
            .iter()
            .map(|text| text.parse().unwrap_or(0))
            .collect()
    };
    for (file, actual) in [("ticks.csv", "t_tick_ns"), ("messages.csv", "t_send_ns")] {
        let mut due = times(file, "t_due_ns");
        let late = due.iter().zip(times(file, actual));
        assert!(
            late.clone()
                .all(|(due, actual)| actual == 0 || actual >= *due),
            "{file}"
        );
        due.sort_unstable();
        assert!(
            due.windows(2).all(|pair| pair[1] - pair[0] == H_NS),
            "{file}"
        );
    }
    let (sent, received) = (
        times("messages.csv", "t_send_ns"),
        times("messages.csv", "t_receive_ns"),
    );
    let mut round_trips = sent
        .iter()
        .zip(&received)
        .filter(|(_, received)| **received != 0);
    // An hour is 3600 s, and no message of this link takes one.
    assert!(round_trips.all(|(sent, received)| (0..1_000_000_000).contains(&(received - sent))));
}
