//! `webloop run --backend compose` that does not run to its end: killed at any moment, or told to end.

use std::fs;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use plan::Verdict;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use rustix::process::{Pid, Signal, kill_process};

use crate::docker::{Decoys, Held};
use crate::webloop::{Experiment, code, column, command, files, manifest, said, was_busy};

/// Runs are killed within this time, so that none ends by itself, even on a quick machine: a run of
/// 8 s takes at least 10 s, one until all containers are healthy and nine of rows and echoes.
const RUN_S: f64 = 9.0;

/// The duration of such a run.
const LOOP: &str = "8s";

/// A request of a killed Compose may take effect in the engine this much later.
const LATE: Duration = Duration::from_secs(1);

/// Time limit after it is told to end: the orchestrator flushes its rows, then all is taken down.
const INTERRUPTED_WITHIN: Duration = Duration::from_secs(15);

pub(crate) fn what_a_killed_run_leaves_is_swept_and_nothing_else() -> Result<(), String> {
    /// Sets the number of moments, for a longer test; four by default.
    const COUNT: &str = "WEBLOOP_TEST_KILLS";
    const SEED: u64 = 4;
    let count: u64 = std::env::var(COUNT).map_or(4, |text| text.parse().expect(COUNT));
    let decoys = Decoys::new();
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["diego-vpn"], "3ms", LOOP);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let before = Held::now();
    let moments: Vec<Duration> = (0..count)
        .map(|n| {
            let within = random.next_u64() as f64 / u64::MAX as f64;
            Duration::from_secs_f64(RUN_S * (n as f64 + within) / count as f64)
        })
        .collect();
    // Side by side, so that each sweep also has to leave the others' alone.
    for moments in moments.chunks(4) {
        let before = &before;
        std::thread::scope(|scope| {
            for &moment in moments {
                scope.spawn(move || kill_at(moment, before));
            }
        });
        assert!(decoys.stand(), "what is not webloop's was touched");
    }
    // The run can still be made.
    let mut run = in_containers(&experiment).spawn().unwrap();
    let pid = run.id();
    let exit = run.wait().unwrap();
    assert!(matches!(exit.code(), Some(0 | 1)), "{exit}");
    let made = manifest(&experiment.cells()[0]);
    assert!(
        made.verdict == Verdict::Complete || was_busy(&made),
        "{}",
        made.verdict
    );
    assert_eq!(Held::now().new_since(&before, pid), [""; 0]);
    assert!(decoys.stand());
    println!(
        "row 1: containers, kill -9 at {count} random instants: `webloop gc` swept what each left"
    );
    println!("row 2: containers, networks and volumes of others: 0 touched in {count} killed runs");
    Ok(())
}

/// Begins a run of its own, kills it after this time, and sweeps what it left.
fn kill_at(moment: Duration, before: &Held) {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["diego-vpn"], "3ms", LOOP);
    let mut run = in_containers(&experiment).spawn().unwrap();
    let pid = run.id();
    std::thread::sleep(moment);
    let early = run.try_wait().unwrap();
    assert!(early.is_none(), "ended before {moment:?}: {early:?}");
    run.kill().unwrap();
    run.wait().unwrap();
    let left = Held::now().new_since(before, pid).len();
    let swept = sweep(before, pid);
    println!(
        "  SIGKILL at {:.3} s: left {left}, swept {swept}",
        moment.as_secs_f64()
    );
}

/// Runs `webloop gc` for all projects of a killed run, until the engine holds what it did `before`.
/// Returns how many things it removed.
///
/// Does not sweep everything: other things of webloop on this engine belong to its user.
fn sweep(before: &Held, pid: u32) -> usize {
    let mut removed = 0;
    // Twice: late requests may make things only after the first round.
    for _ in 0..2 {
        for project in Held::now().projects_of(pid) {
            let gc = command()
                .args(["gc", "--project", &project])
                .output()
                .unwrap();
            assert_eq!(code(&gc), Some(0), "{}", said(&gc));
            removed += said(&gc).matches("removed ").count();
            assert_eq!(Held::now().projects_of(pid), [""; 0], "{}", said(&gc));
        }
        std::thread::sleep(LATE);
    }
    assert_eq!(Held::now().new_since(before, pid), [""; 0]);
    removed
}

pub(crate) fn a_run_that_is_told_to_end_takes_its_containers_with_it() -> Result<(), String> {
    let before = Held::now();
    // Side by side, so that each also has to leave the others' alone.
    std::thread::scope(|scope| {
        for signal in [Signal::INT, Signal::TERM] {
            let before = &before;
            scope.spawn(move || tell_in_the_middle(signal, before));
        }
        scope.spawn(|| tell_while_it_comes_up(&before));
    });
    Ok(())
}

fn tell_in_the_middle(signal: Signal, before: &Held) {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["diego-vpn"], "3ms", "20s");
    let mut run = in_containers(&experiment).spawn().unwrap();
    await_rows(&mut run, &experiment);
    tell(run, signal, &format!("{signal:?} in the middle"), before);
    let cell = &experiment.cells()[0];
    let manifest = manifest(cell);
    assert_eq!(manifest.verdict, Verdict::Failed);
    assert!(
        manifest.reasons.join(" ").contains("interrupted"),
        "{:?}",
        manifest.reasons
    );
    // Everything that plant and controller counted is in their files.
    let files = files(cell);
    let ticks = column(&files["ticks.csv"], "t_tick_ns").len();
    let plant = manifest.plant.unwrap();
    assert_eq!(plant.real().unwrap().ticks, ticks as u64);
    let messages = column(&files["messages.csv"], "seq").len();
    let rows = manifest.controller.unwrap().rows().rows;
    assert_eq!(rows, messages as u64);
}

/// Told to end before any role runs: while Compose brings the containers up.
fn tell_while_it_comes_up(before: &Held) {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["diego-vpn"], "3ms", "2s");
    let run = in_containers(&experiment).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1_500));
    tell(run, Signal::TERM, "TERM while it comes up", before);
}

/// Tells a run to end, which it has to do soon and without leaving anything.
fn tell(run: Child, signal: Signal, when: &str, before: &Held) {
    let (pid, signalled) = (run.id(), Instant::now());
    send(&run, signal);
    let output = run.wait_with_output().unwrap();
    let took = signalled.elapsed();
    println!("  {when}: ended after {:.1} s", took.as_secs_f64());
    assert_eq!(code(&output), Some(130), "{}", said(&output));
    assert!(took < INTERRUPTED_WITHIN, "{took:?}");
    assert_eq!(Held::now().new_since(before, pid), [""; 0]);
}

fn in_containers(experiment: &Experiment) -> Command {
    let mut command = experiment.run(command());
    command.args(["--backend", "compose", "--no-build", "--player", "user"]);
    command
}

fn send(run: &Child, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(run.id()).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

/// Waits until the loop is closed and its rows are copied to the host.
fn await_rows(run: &mut Child, experiment: &Experiment) {
    let deadline = Instant::now() + Duration::from_secs(60);
    let rows = |experiment: &Experiment| {
        experiment.out.join("plan.json").exists()
            && experiment.cells().iter().any(|cell| {
                fs::read(cell.join("messages.csv"))
                    .is_ok_and(|text| column(&text, "seq").len() > 50)
            })
    };
    while !rows(experiment) {
        assert!(Instant::now() < deadline, "no message within a minute");
        assert!(run.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(50));
    }
}
