use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::thread;

use backend::{Backend, Player, Timings, Virtual};
use plan::Verdict;
use record::Manifest;

use super::*;
use crate::earlier::Own;
use crate::sample::plan;

/// Records how each cell ended, by its index. Sets the flag when one has.
#[derive(Default)]
struct Told<'a> {
    ends: Mutex<Vec<(usize, Verdict, String)>>,
    stop: Option<&'a AtomicBool>,
}

impl Progress for Told<'_> {
    fn say(&self, _: &str) {}
    fn on_begun(&self, _: &Cell) {}
    fn on_left(&self, _: &Cell) {}
    fn on_ended(&self, cell: &Cell, verdict: Verdict, reason: &str) {
        let mut ends = self.ends.lock().expect("no panic");
        ends.push((cell.index, verdict, reason.to_owned()));
        if let Some(stop) = self.stop {
            stop.store(true, Ordering::Relaxed);
        }
    }
}

/// Simulates a plan of four cells on `jobs` threads, each after `before` it. Returns how they ended, and those that
/// have a manifest then.
fn simulate(
    jobs: u16,
    before: impl Fn(&Cell) -> Result<(), Error> + Sync,
    stop: &AtomicBool,
    stops: bool,
) -> (Vec<(usize, Verdict, String)>, Vec<usize>) {
    let sample_times = "\"100ms\", \"200ms\", \"300ms\", \"400ms\"";
    let plan = plan(&[("\"native\"", sample_times, 1)]);
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let folder = tempfile::tempdir().expect("a folder");
    let timings = Timings::built_in().expect("built in");
    let how = CellRun {
        campaign: folder.path(),
        backend: &Backend::Sim(Box::new(Virtual::new(timings))),
        player: Player::Auto,
        own: Own {
            backend: "sim".to_owned(),
            player: None,
        },
        tries: 1,
        together: 1,
    };
    let make = |cell: &Cell| {
        before(cell)?;
        tries::make(&plan, cell, &how, stop)
    };
    let told = Told {
        stop: stops.then_some(stop),
        ..Told::default()
    };
    let queue = Queue::unmeasured(&cells, jobs);
    let words = |problem: Error| format!("webloop: {problem}");
    run(&queue, folder.path(), make, stop, &told, words).expect("cells end");
    let kept = |cell: &&Cell| {
        Manifest::read(&folder.path().join(cell.folder()))
            .expect("whole")
            .is_some()
    };
    let kept = plan.cells.iter().filter(kept).map(|cell| cell.index);
    let mut ends = told.ends.into_inner().expect("no panic");
    ends.sort_unstable_by_key(|(index, ..)| *index);
    (ends, kept.collect())
}

fn complete(index: usize) -> (usize, Verdict, String) {
    (index, Verdict::Complete, String::new())
}

#[test]
fn a_cell_that_panics_or_cannot_be_run_has_failed_and_the_others_go_on() {
    for jobs in [1, 3] {
        let before = |cell: &Cell| match cell.index {
            1 => panic!("nobody expected {}", cell.index),
            2 => Err(Error::DamagedCell("it is damaged".to_owned())),
            _ => Ok(()),
        };
        let (ends, kept) = simulate(jobs, before, &AtomicBool::new(false), false);
        let failed = |index, words: &str| (index, Verdict::Failed, words.to_owned());
        let panicked = failed(1, "its thread panicked: nobody expected 1");
        let damaged = "webloop: it is damaged; restore it, or move the cell's folder away to have it run again";
        assert_eq!(
            ends,
            [complete(0), panicked, failed(2, damaged), complete(3)]
        );
        assert_eq!(kept, [0, 3]);
    }
}

#[test]
fn once_the_campaign_is_told_to_stop_no_cell_begins_and_those_under_way_say_so() {
    let stop = AtomicBool::new(false);
    let before = |cell: &Cell| {
        if cell.index == 1 {
            stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    };
    let (ends, kept) = simulate(1, before, &stop, false);
    let interrupted = (1, Verdict::Failed, "interrupted".to_owned());
    assert_eq!(ends, [complete(0), interrupted]);
    assert_eq!(kept, [0, 1]);
}

/// A manifest is there when its cell is told of, and not only at the end.
#[test]
fn a_cell_has_its_manifest_while_others_are_still_run() {
    let stop = AtomicBool::new(false);
    let before = |cell: &Cell| {
        // Until the first has ended, which sets the flag.
        while cell.index == 1 && !stop.load(Ordering::Relaxed) {
            thread::yield_now();
        }
        Ok(())
    };
    let (ends, kept) = simulate(1, before, &stop, true);
    assert_eq!(ends[0], complete(0));
    assert_eq!(kept, [0, 1]);
}
