use std::fs;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use plan::{Cell, Plan};
use record::Manifest;

use super::*;
use crate::sample::{manifest, now_ns, plan};

/// What the fake program does for a cell.
#[derive(Clone, Copy)]
enum Does {
    /// Leaves a manifest with this verdict, and ends.
    Ends(Verdict),
    /// Ends without a manifest, with these last words.
    Says(&'static str),
    /// Does nothing until it is told to end.
    Hangs,
    /// Cannot be started.
    Fails,
}

/// A fake program; `does` has an entry for each cell, by index.
struct Made<'a> {
    campaign: &'a Path,
    does: &'a [Does],
    /// The cells that were started, each with its tries.
    started: Mutex<Vec<(usize, u8)>>,
}

impl Program for Made<'_> {
    fn run(&self, turn: &Turn<'_>, tries: u8, stop: &AtomicBool) -> Result<String, Error> {
        let cell = turn.cell;
        self.started
            .lock()
            .expect("no panic")
            .push((cell.index, tries));
        match self.does[cell.index] {
            Does::Ends(verdict) => {
                let folder = self.campaign.join(cell.folder());
                let manifest = manifest(cell, verdict, &["why"]);
                fs::create_dir_all(&folder)?;
                fs::write(folder.join(Manifest::FILE), manifest.to_json())?;
                Ok(String::new())
            }
            Does::Says(words) => Ok(words.to_owned()),
            Does::Hangs => {
                while !stop.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                Ok("interrupted".to_owned())
            }
            Does::Fails => Err(Error::Io(std::io::Error::other("no more processes"))),
        }
    }
}

/// Records progress events in order.
#[derive(Default)]
struct Told<'a> {
    events: Mutex<Vec<String>>,
    /// The flag to set when the cell of this index begins.
    stop: Option<(usize, &'a AtomicBool)>,
}

impl Told<'_> {
    fn add(&self, event: String) {
        self.events.lock().expect("no panic").push(event);
    }
}

impl Progress for Told<'_> {
    fn say(&self, words: &str) {
        self.add(words.to_owned());
    }

    fn on_begun(&self, cell: &Cell) {
        self.add(format!("{} begun", cell.index));
        if let Some((_, stop)) = self.stop.filter(|(index, _)| *index == cell.index) {
            stop.store(true, Ordering::Relaxed);
        }
    }

    fn on_left(&self, cell: &Cell) {
        self.add(format!("{} left", cell.index));
    }

    fn on_ended(&self, cell: &Cell, verdict: Verdict, reason: &str) {
        self.add(format!("{} {verdict}: {reason}", cell.index));
    }
}

/// A plan of four cells, each of which runs alone.
fn alone() -> Plan {
    plan(&[(
        "\"native\"",
        "\"100ms\", \"200ms\", \"300ms\", \"400ms\"",
        1,
    )])
}

/// The outcome of running a plan.
struct Came {
    /// The cells that are to be asked again, by their indices.
    outcome: Result<Vec<usize>, Error>,
    /// The cells that were started, each with its tries.
    started: Vec<(usize, u8)>,
    told: Vec<String>,
}

/// Runs a plan with the fake program. Sets the stop flag when the cell `stop_at` begins.
fn make(plan: &Plan, does: &[Does], stop_at: Option<usize>) -> Came {
    let folder = tempfile::tempdir().expect("a folder");
    let stop = AtomicBool::new(false);
    let program = Made {
        campaign: folder.path(),
        does,
        started: Mutex::default(),
    };
    let told = Told {
        stop: stop_at.map(|index| (index, &stop)),
        ..Told::default()
    };
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let queue = Queue::new(&cells, None, now_ns);
    let outcome = run(&queue, folder.path(), &program, 3, &stop, &told);
    let outcome = outcome.map(|again| again.iter().map(|cell| cell.index).collect());
    Came {
        outcome,
        started: program.started.into_inner().expect("no panic"),
        told: told.events.into_inner().expect("no panic"),
    }
}

#[test]
fn each_cell_is_told_of_as_its_manifest_has_it_and_else_by_its_programs_last_words() {
    let does = [
        Does::Ends(Verdict::Complete),
        Does::Says("the plant has gone"),
        Does::Ends(Verdict::Disturbed),
        Does::Ends(Verdict::Unsupported),
    ];
    let Came {
        outcome,
        started,
        told,
    } = make(&alone(), &does, None);
    let again = outcome.expect("cells that fail are no failure of the campaign");
    assert!(again.is_empty(), "its own program has asked it: {again:?}");
    // A cell that runs alone may be repeated by its own program.
    assert_eq!(started, [(0, 3), (1, 3), (2, 3), (3, 3)]);
    let ends = [
        "complete: why",
        "failed: the plant has gone",
        "disturbed: why",
        "unsupported: why",
    ];
    let of_cell = |(n, end): (usize, &&str)| {
        [
            format!("{n} begun"),
            format!("{n} left"),
            format!("{n} {end}"),
        ]
    };
    let expected: Vec<String> = ends.iter().enumerate().flat_map(of_cell).collect();
    assert_eq!(told, expected);
}

#[test]
fn a_cell_beside_others_is_left_to_be_asked_again_after_them() {
    let plan = plan(&[("\"native\"", "\"100ms\", \"200ms\"", 2)]);
    let Came {
        outcome,
        mut started,
        ..
    } = make(&plan, &[Does::Ends(Verdict::Disturbed); 2], None);
    assert_eq!(outcome.expect("both have ended"), [0, 1]);
    started.sort_unstable();
    assert_eq!(started, [(0, 1), (1, 1)]);
}

#[test]
fn a_cell_that_hangs_is_told_to_end_once_the_campaign_is_and_no_other_begins() {
    let does = [
        Does::Ends(Verdict::Complete),
        Does::Hangs,
        Does::Hangs,
        Does::Hangs,
    ];
    let Came {
        outcome,
        started,
        told,
    } = make(&alone(), &does, Some(1));
    let again = outcome.expect("being told to stop is no failure");
    assert!(again.is_empty(), "{again:?}");
    assert_eq!(started, [(0, 3), (1, 3)]);
    assert_eq!(
        told.last().map(String::as_str),
        Some("1 failed: interrupted")
    );
}

#[test]
fn a_program_that_cannot_be_started_ends_the_campaign_and_its_cell_is_not_waited_for() {
    let does = [
        Does::Ends(Verdict::Complete),
        Does::Fails,
        Does::Hangs,
        Does::Hangs,
    ];
    let Came {
        outcome,
        started,
        told,
    } = make(&alone(), &does, None);
    assert_eq!(
        outcome.expect_err("no process").to_string(),
        "no more processes"
    );
    assert_eq!(started.len(), 2);
    assert_eq!(told.last().map(String::as_str), Some("1 left"));
}
