//! Runs that end early: told to, or killed.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use plan::Verdict;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use rustix::process::{Pid, Signal, kill_process, kill_process_group};

use crate::complete::came_to_its_end;
use crate::decoy::Decoys;
use crate::process::{gone, namespaces_of, of_run};
use crate::webloop::{Experiment, code, column, command, files, manifest, said};

/// Nothing may be left of a killed run after this; the issue sets this limit.
pub(crate) const GONE_WITHIN: Duration = Duration::from_secs(5);

/// Rows older than this are on disk, whatever happens; the issue sets this limit.
const ON_DISK_AFTER_NS: u64 = 1_000_000_000;

pub(crate) fn an_interrupted_run_ends_soon_with_its_rows() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "3ms", "6s");
    // `kill` reaches the orchestrator alone, Ctrl-C on a terminal every process of the run.
    for (who, send) in [
        ("the orchestrator", kill_process as fn(Pid, Signal) -> _),
        ("every process", kill_process_group),
    ] {
        let mut run = experiment.run(command()).process_group(0).spawn().unwrap();
        await_rows(&mut run, &experiment);
        let namespaces = namespaces_of(&of_run(&experiment.out));
        let (signalled, signalled_ns) = (Instant::now(), now_ns());
        send(number(&run), Signal::INT).unwrap();
        let output = run.wait_with_output().unwrap();
        let took = signalled.elapsed();
        // Three roles, each of which has to flush a file: some ms. The issue sets the limit of 5 s.
        assert!(took < Duration::from_secs(5), "{who}: {took:?}");
        assert_eq!(code(&output), Some(130), "{who}: {}", said(&output));
        gone(&experiment.out, &namespaces, GONE_WITHIN);
        println!("  SIGINT to {who}: ended after {:.2} s", took.as_secs_f64());

        let cell = &experiment.cells()[0];
        let manifest = manifest(cell);
        assert_eq!(manifest.verdict, Verdict::Failed);
        assert!(
            manifest.reasons.join(" ").contains("interrupted"),
            "{who}: {:?}",
            manifest.reasons
        );
        // The plant ended by itself, so its file goes up to the signal and has as many rows as it
        // counted. One sleep of the player's roles lies in between.
        let ticks = column(&fs::read(cell.join("ticks.csv")).unwrap(), "t_tick_ns");
        let last_ns: u64 = ticks.last().unwrap().parse().unwrap();
        assert!(last_ns + 100_000_000 > signalled_ns, "{who}");
        let plant = manifest.plant.unwrap();
        assert_eq!(plant.real().unwrap().ticks, ticks.len() as u64, "{who}");
        let messages = column(&fs::read(cell.join("messages.csv")).unwrap(), "seq");
        let rows = manifest.controller.unwrap().rows().rows;
        assert_eq!(rows, messages.len() as u64, "{who}");
    }
    Ok(())
}

/// Waits until the loop is closed: 2.3 s after the start, or 8.3 s with a browser.
pub(crate) fn await_rows(run: &mut Child, experiment: &Experiment) {
    // Four times as long, for a busy machine.
    let within = Duration::from_secs(33);
    let deadline = Instant::now() + within;
    let rows = |experiment: &Experiment| {
        experiment.out.join("plan.json").exists()
            && experiment.cells().iter().any(|cell| {
                fs::read(cell.join("messages.csv"))
                    .is_ok_and(|text| column(&text, "seq").len() > 50)
                    && !cell.join("manifest.json").exists()
            })
    };
    while !rows(experiment) {
        assert!(Instant::now() < deadline, "no message within {within:?}");
        assert!(run.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What a killed run had, and how long it stayed.
#[derive(Debug)]
pub(crate) struct Killed {
    pub(crate) processes: usize,
    pub(crate) namespaces: usize,
    pub(crate) gone_after: Duration,
    pub(crate) at_ns: u64,
}

/// Kills only the orchestrator, and waits until nothing is left.
pub(crate) fn kill(run: &mut Child, out: &Path) -> Killed {
    let processes = of_run(out);
    let namespaces = namespaces_of(&processes);
    let at_ns = now_ns();
    run.kill().unwrap();
    run.wait().unwrap();
    Killed {
        processes: processes.len(),
        namespaces: namespaces.len(),
        gone_after: gone(out, &namespaces, GONE_WITHIN),
        at_ns,
    }
}

pub(crate) fn a_killed_run_leaves_rows_and_nothing_else_and_can_be_continued() -> Result<(), String>
{
    /// Sets the number of moments, for a longer test; six by default.
    const COUNT: &str = "WEBLOOP_TEST_KILLS";
    let count: u64 = std::env::var(COUNT).map_or(6, |text| text.parse().expect(COUNT));
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "3ms", "4s");
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut left = Vec::new();
    let (mut longest, mut oldest_ns, mut torn) = (Duration::ZERO, 0, 0);
    let mut decoys = Decoys::make();
    for n in 0..count {
        // The run takes at least 4.4 s, and is killed within the first 4 s. By the third power half
        // of the moments fall into the first half second, in which namespaces and processes are
        // made. All runs use one folder: each continues what was killed before.
        let within = random.next_u64() as f64 / u64::MAX as f64;
        let moment = 4.0 * ((n as f64 + within) / count as f64).powi(3);
        let moment = Duration::from_secs_f64(moment);
        let mut run = experiment.run(command()).spawn().unwrap();
        std::thread::sleep(moment);
        assert!(run.try_wait().unwrap().is_none(), "ended before {moment:?}");
        let killed = kill(&mut run, &experiment.out);
        longest = longest.max(killed.gone_after);
        let rows = rows_left(&experiment);
        let ticks = rows.get("ticks.csv").map(|csv| column(csv, "t_tick_ns"));
        let last_ns: Option<u64> = ticks
            .as_ref()
            .and_then(|ticks| ticks.last())
            .map(|t_ns| t_ns.parse().unwrap());
        let missing_ns = last_ns.map(|t_ns| killed.at_ns.saturating_sub(t_ns));
        println!(
            "  SIGKILL at {:.3} s: {} processes, {} namespaces, all gone after {:.3} s; {}",
            moment.as_secs_f64(),
            killed.processes,
            killed.namespaces,
            killed.gone_after.as_secs_f64(),
            missing_ns.map_or("no rows yet".into(), |ns| {
                format!("rows up to {:.3} s before", ns as f64 / 1e9)
            }),
        );
        // The plant ticks some 0.1 s after the start; half a second for a busy machine.
        if moment > Duration::from_millis(1_500) {
            assert!(killed.processes >= 5, "{killed:?}");
            assert!(
                missing_ns.is_some_and(|ns| ns < ON_DISK_AFTER_NS),
                "{missing_ns:?}"
            );
        }
        // Before a plant has ticked for as long as its rows may be under way, there are none to be lost.
        if moment > Duration::from_millis(1_500) {
            oldest_ns = oldest_ns.max(missing_ns.unwrap_or(u64::MAX));
        }
        let csv = rows.iter().filter(|(name, _)| name.ends_with(".csv"));
        torn += csv.filter(|(_, text)| !text.ends_with(b"\n")).count();
        left.extend((!rows.is_empty()).then_some(rows));
    }
    println!(
        "row 1: namespaces, kill -9 at {count} random instants: {count} of {count} left no process and no namespace, with its veth, TUN and qdisc, the slowest after {:.2} s",
        longest.as_secs_f64()
    );
    println!(
        "row 2: {}: 0 touched in {count} killed runs",
        decoys.check()
    );
    println!(
        "row 6: {count} kill -9: the newest row {:.2} s old at the most; {torn} files ended in a part of a line",
        oldest_ns as f64 / 1e9
    );

    let output = experiment.complete()?;
    assert_eq!(code(&output), Some(0), "{}", said(&output));
    came_to_its_end(&manifest(&experiment.cells()[0]));
    // What each killed run left is kept beside the cell, byte by byte.
    let aside: Vec<_> = fs::read_dir(experiment.out.join("cells"))
        .unwrap()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().contains("unfinished"))
        .map(|entry| files(&entry.path()))
        .collect();
    assert!(!left.is_empty());
    assert!(left.iter().all(|rows| aside.contains(rows)));
    Ok(())
}

/// The files of the one cell, if it was begun.
fn rows_left(experiment: &Experiment) -> BTreeMap<String, Vec<u8>> {
    if experiment.out.join("plan.json").exists() {
        files(&experiment.cells()[0])
    } else {
        BTreeMap::new()
    }
}

fn number(run: &Child) -> Pid {
    Pid::from_raw(i32::try_from(run.id()).unwrap()).unwrap()
}
