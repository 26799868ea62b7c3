//! Of two runs into one folder, and of two runs of one cell, only one runs.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

use crate::ending::kill;
use crate::process::of_run;
use crate::webloop::{Experiment, code, command, said};

/// Being refused takes some ms; the run itself takes 10 s.
const REFUSED_WITHIN: Duration = Duration::from_secs(1);

/// Starts both at once, so that the kernel decides which one wins. Returns the winner, what the other said, and how
/// long that took.
fn race(start: impl Fn() -> Command) -> (Child, Output, Duration) {
    let mut runs = [(); 2].map(|()| start().spawn().unwrap());
    let started = Instant::now();
    let ended = |run: &mut Child| run.try_wait().unwrap().is_some();
    while started.elapsed() < 4 * REFUSED_WITHIN && !runs.iter_mut().any(ended) {
        std::thread::sleep(Duration::from_millis(2));
    }
    let took = started.elapsed();
    let [winner, loser] = match runs.each_mut().map(ended) {
        [false, true] => runs,
        [true, false] => {
            let [a, b] = runs;
            [b, a]
        }
        other => panic!("of two runs, have ended: {other:?}"),
    };
    (winner, loser.wait_with_output().unwrap(), took)
}

/// `WEBLOOP_TEST_DOUBLES=50` makes as many double starts, half of them of `run`, half of `run-cell`. All go into one
/// folder, and each winner is killed: a lock that outlived it would refuse both of the next.
pub(crate) fn of_two_runs_into_one_folder_one_runs() -> Result<(), String> {
    const COUNT: &str = "WEBLOOP_TEST_DOUBLES";
    let count: usize = std::env::var(COUNT).map_or(4, |count| count.parse().expect(COUNT));
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "3ms", "6s");
    let plan = folder.path().join("plan.json");
    let mut matrix = command();
    let matrix = matrix
        .arg("matrix")
        .arg(&experiment.file)
        .arg("--plan")
        .arg(&plan);
    let output = matrix.output().unwrap();
    assert_eq!(code(&output), Some(0), "{}", said(&output));
    let run_cell = || {
        let mut command = command();
        command
            .args(["run-cell", "--index", "0", "--plan"])
            .arg(&plan);
        command.arg("--out").arg(&experiment.out);
        command
    };
    let mut slowest = Duration::ZERO;
    for n in 0..count {
        let (mut winner, refused, took) = match n % 2 {
            0 => race(|| experiment.run(command())),
            _ => race(run_cell),
        };
        slowest = slowest.max(took);
        let words = said(&refused);
        assert_eq!(code(&refused), Some(2), "{words}");
        assert!(
            words.contains("in use") && words.contains("--out"),
            "{words}"
        );
        assert!(took < REFUSED_WITHIN, "{took:?}");
        // The other one goes on, and only its processes write there.
        std::thread::sleep(Duration::from_millis(500));
        assert!(winner.try_wait().unwrap().is_none(), "{n}");
        assert!(of_run(&experiment.out).contains(&winner.id()));
        kill(&mut winner, &experiment.out);
        let others: Vec<String> = names(&experiment.out)
            .into_iter()
            .filter(|name| !["plan.json", ".lock", "cells"].contains(&name.as_str()))
            .collect();
        assert!(others.is_empty(), "{others:?}");
    }
    println!(
        "row 10: {count} double starts, half of them of one cell: each time one ran, the other was refused within {:.2} s; {count} killed left no lock",
        slowest.as_secs_f64()
    );
    Ok(())
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}
