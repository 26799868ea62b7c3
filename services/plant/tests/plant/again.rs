//! A second life: a plant that goes on with the files of one that was killed.

use std::{fs::OpenOptions, io::Write, path::Path};

use control::Signals;
use endpoint::{ArrivalRow, Model, SecondRow, TickRow};
use plant::Config;

use crate::support::{Line, config, motor, observe, rows, with_model};

/// Gives both its inputs back.
struct Wires;

impl Model for Wires {
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        u
    }

    fn at_rest(&self) -> Signals {
        [0.0, 0.0].into()
    }

    fn inputs(&self) -> usize {
        2
    }
}

/// A life with two commands; when its tick 0 was due.
fn life(out: &Path, again: bool) -> u64 {
    let config = Config {
        again,
        ..config(out)
    };
    let mut start_ns = None;
    let report = with_model(config, Wires, |ready| {
        start_ns = Some(ready.start_ns);
        let mut line = Line::open(ready.address);
        let first = observe(ready.address).tick;
        line.wait_for("a tick without a command", |state| state.tick > first);
        for _ in 0..2 {
            let (status, _) = line.get("/closed?u=0.5,0.25", "");
            assert_eq!(status, 200);
        }
        line.wait_for("a tick with u", |state| state.y.first > 0.0);
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.arrival_rows.rows), (2, 2));
    assert_eq!(Some(report.start_ns), start_ns);
    report.start_ns
}

#[test]
fn ticks_and_arrivals_are_counted_on_and_the_model_begins_anew() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name| folder.path().join(name);
    let start_ns = life(folder.path(), false);
    let before: Vec<TickRow> = rows(&file(TickRow::FILE));
    assert_eq!(life(folder.path(), true), start_ns);

    let ticks: Vec<TickRow> = rows(&file(TickRow::FILE));
    assert_eq!(ticks[..before.len()], before);
    assert!(
        ticks
            .iter()
            .all(|row| row.t_due_ns == start_ns + row.k * 3_000_000)
    );
    assert!(ticks.windows(2).all(|pair| pair[0].k < pair[1].k));
    let first = ticks[before.len()];
    assert_eq!((first.u, first.y, first.seq), (0.0, 0.0, None));
    let second: Vec<SecondRow> = rows(&file(SecondRow::FILE));
    assert!(
        second
            .iter()
            .map(|row| row.k)
            .eq(ticks.iter().map(|row| row.k))
    );
    let arrivals: Vec<ArrivalRow> = rows(&file(ArrivalRow::FILE));
    assert!(arrivals.iter().map(|row| row.n).eq(0..4));
    // A command without a number has that of its arrival.
    assert!(arrivals.iter().all(|row| row.seq == row.n));
}

#[test]
fn ticks_that_are_still_to_come_are_no_earlier_life_s() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    life(folder.path(), false);
    let path = folder.path().join(TickRow::FILE);
    let mut file = OpenOptions::new()
        .append(true)
        .open(&path)
        .expect("the file");
    let ahead = format!("999999,{},{},0.0,0.0,,0.0\n", u64::MAX, u64::MAX);
    file.write_all(ahead.as_bytes()).expect("a writable file");
    let config = Config {
        again: true,
        ..config(folder.path())
    };
    let model = motor(&config);
    let refused = plant::serve(&config, model, |_| panic!("it is ready"));
    let error = refused.expect_err("it cannot go on").to_string();
    assert!(
        error.contains("ticks.csv") && error.contains(&u64::MAX.to_string()),
        "{error}"
    );
}
