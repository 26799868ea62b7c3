//! Following files: what is here is at any time a beginning of what is there, and all of it at
//! the end.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use containers::{Error, RemoteRun};

use crate::served::{SOON, Served};

/// The row on disk within this: the issue's own figure, and as much again for a busy machine.
const FRESH: Duration = Duration::from_secs(2);

fn start(run: &RemoteRun, how: &str) {
    run.start("plant", "plant", serde_json::json!({ "h": how }))
        .unwrap();
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_default()
}

#[test]
fn files_that_grow_by_half_rows_arrive_whole() {
    serial::timed("files_that_grow_by_half_rows_arrive_whole", || {
        let served = Served::unclaimed(|_| {});
        let run = served.remote().begin("r1").unwrap();
        let (here, there) = (tempfile::tempdir().unwrap(), served.scratch().join("r1"));
        let files = ["ticks.csv", "arrivals.csv", "plant.json", "never.csv"];
        let follower = run.follow(&files, here.path()).unwrap();
        start(&run, "grows");
        let (begun, mut looks) = (Instant::now(), 0);
        while begun.elapsed() < Duration::from_secs(2) {
            let row = read(&there, "ticks.csv");
            thread::sleep(Duration::from_millis(100));
            let (copy, now) = (read(here.path(), "ticks.csv"), read(&there, "ticks.csv"));
            assert!(now.starts_with(&copy));
            looks += 1;
            // What was there before must be here soon.
            let deadline = Instant::now() + FRESH;
            while !read(here.path(), "ticks.csv").starts_with(&row) {
                assert!(Instant::now() < deadline, "not here within {FRESH:?}");
                thread::sleep(Duration::from_millis(10));
            }
        }
        assert!(looks > 2);
        run.stop("plant").unwrap();
        follower.finish().unwrap();
        for name in &files[..3] {
            let original = read(&there, name);
            assert!(
                !original.is_empty() && original == read(here.path(), name),
                "{name}"
            );
        }
        assert!(read(here.path(), "ticks.csv").ends_with(b"last\n"));
        assert_eq!(read(here.path(), "arrivals.csv").len(), 3_000_000);
        assert_eq!(fs::read_dir(here.path()).unwrap().count(), 3);
    });
}

#[test]
fn rows_that_are_here_already_are_not_added_to() {
    let served = Served::unclaimed(|_| {});
    let run = served.remote().begin("r1").unwrap();
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("ticks.csv"), "of an earlier run").unwrap();
    fs::write(served.scratch().join("r1/ticks.csv"), "new").unwrap();
    let error = run
        .follow(&["ticks.csv"], here.path())
        .unwrap()
        .finish()
        .unwrap_err();
    assert!(matches!(error, Error::Write { .. }), "{error}");
    assert!(error.to_string().contains("ticks.csv"), "{error}");
    assert_eq!(read(here.path(), "ticks.csv"), b"of an earlier run");
}

#[test]
fn a_file_that_became_shorter_is_not_copied_on() {
    let served = Served::unclaimed(|_| {});
    let run = served.remote().begin("r1").unwrap();
    let here = tempfile::tempdir().unwrap();
    let there = served.scratch().join("r1/ticks.csv");
    fs::write(&there, "long enough").unwrap();
    let follower = run.follow(&["ticks.csv"], here.path()).unwrap();
    let deadline = Instant::now() + SOON;
    while read(here.path(), "ticks.csv").is_empty() {
        assert!(Instant::now() < deadline);
        thread::sleep(Duration::from_millis(10));
    }
    fs::write(&there, "short").unwrap();
    while !follower.ended() {
        assert!(Instant::now() < deadline);
        thread::sleep(Duration::from_millis(10));
    }
    assert!(matches!(follower.finish(), Err(Error::Shrunk { .. })));
}

#[test]
fn one_that_is_dropped_ends_at_once() {
    serial::timed("one_that_is_dropped_ends_at_once", || {
        let served = Served::unclaimed(|_| {});
        let run = served.remote().begin("r1").unwrap();
        let here = tempfile::tempdir().unwrap();
        let follower = run.follow(&["ticks.csv"], here.path()).unwrap();
        let begun = Instant::now();
        drop(follower);
        assert!(begun.elapsed() < Duration::from_secs(5));
    });
}
