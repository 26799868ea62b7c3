//! A campaign that was interrupted, and one of which a part failed: continued by `--resume`, and
//! repeated by `--failed`. Complete cells are left alone.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use plan::Verdict;
use record::Manifest;

use crate::ending::kill;
use crate::webloop::{
    Experiment, cells_of, code, command, files, manifest, said, too_busy, was_busy,
};

/// The variable that names the browser; one that does not exist, and one that ends as soon as it is
/// started.
const BROWSER: &str = "WEBLOOP_CHROMIUM";
const NO_BROWSER: &str = "/nonexistent";
const BAD_BROWSER: &str = "/bin/false";

pub(crate) fn a_campaign_goes_on_where_it_was_broken_off_and_only_what_failed_is_made_again()
-> Result<(), String> {
    let is_made = || serial::tries().any(|_| break_off_and_go_on().is_ok());
    is_made()
        .then_some(())
        .ok_or_else(|| too_busy("one of the cells"))
}

/// The machine held up a cell.
struct Busy;

fn break_off_and_go_on() -> Result<(), Busy> {
    let stolen = serial::Stolen::since_now();
    let folder = tempfile::tempdir().unwrap();
    let mut experiment = of_two_clients(folder.path());
    let refused = run(folder.path(), &["--resume"], BAD_BROWSER);
    assert_eq!(code(&refused), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("nothing to continue"));

    // Kill it in its second cell.
    let mut first = begin(folder.path(), &[], BAD_BROWSER).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(180);
    experiment.out = loop {
        assert!(Instant::now() < deadline, "no cell was complete in time");
        std::thread::sleep(Duration::from_millis(20));
        match results(folder.path()).as_slice() {
            [out] if ended(out).len() == 1 => break out.clone(),
            _ => {}
        }
    };
    // Its processes know the folder by this relative path.
    let name = experiment.out.strip_prefix(folder.path()).unwrap();
    kill(&mut first, name);
    let cells = experiment.cells();
    let done = files(&cells[0]);
    is_complete(&cells[0], &stolen)?;

    // Nothing has failed so far, so there is nothing to repeat.
    let none = run(folder.path(), &["--failed"], BAD_BROWSER);
    assert_eq!(code(&none), Some(1), "{}", said(&none));
    assert!(said(&none).contains("0 cells (3 others are left alone)"));
    assert_eq!(ended(&experiment.out).len(), 1);

    let resumed = run(folder.path(), &["--resume"], BAD_BROWSER);
    assert_eq!(code(&resumed), Some(1), "{}", said(&resumed));
    assert!(said(&resumed).contains("2 cells (1 others are left alone)"));
    assert_eq!(
        results(folder.path()),
        std::slice::from_ref(&experiment.out)
    );
    is_complete(&cells[1], &stolen)?;
    let verdicts = || [0, 1, 2].map(|index: usize| manifest(&cells[index]).verdict);
    let complete = Verdict::Complete;
    assert_eq!(verdicts(), [complete, complete, Verdict::Failed]);
    assert_eq!(files(&cells[0]), done);

    // Repeat what failed. Here the browser is missing instead, which gives another verdict.
    let (alone, failed) = (
        [0, 1].map(|index: usize| files(&cells[index])),
        files(&cells[2]),
    );
    let again = run(folder.path(), &["--failed"], NO_BROWSER);
    assert_eq!(code(&again), Some(3), "{}", said(&again));
    assert!(said(&again).contains("1 cell (2 others are left alone)"));
    assert_eq!(verdicts(), [complete, complete, Verdict::Unsupported]);
    assert_eq!([0, 1].map(|index: usize| files(&cells[index])), alone);
    let aside = PathBuf::from(format!("{}.unfinished-1", cells[2].display()));
    assert_eq!(files(&aside), failed);

    // With another seed there is no campaign to continue.
    let other = run(folder.path(), &["--resume", "--seed", "2"], BAD_BROWSER);
    assert_eq!(code(&other), Some(2), "{}", said(&other));
    Ok(())
}

/// Checks that a cell that was run is complete, unless the machine held it up.
fn is_complete(cell: &Path, stolen: &serial::Stolen) -> Result<(), Busy> {
    if !cell.join(Manifest::FILE).exists() {
        // It had ended, and was moved aside for another try.
        println!("  too busy: a try of it was disturbed");
        return Err(Busy);
    }
    let manifest = manifest(cell);
    if was_busy(&manifest) || manifest.verdict != Verdict::Complete && stolen.is_much() {
        println!("  too busy: {:?}", manifest.reasons);
        return Err(Busy);
    }
    assert_eq!(manifest.verdict, Verdict::Complete);
    Ok(())
}

/// Two cells that run on any machine, and one that needs a browser.
fn of_two_clients(folder: &Path) -> Experiment {
    let experiment = Experiment::new(folder, &["arima"], "10ms", "1s");
    let block = |client: &str, h: &str| {
        format!(
            "[[cells]]\ntopology = [\"arima\"]\nclient = [\"{client}\"]\nmode = \"closed\"\n\
             h = [{h}]\nduration = \"1s\"\n"
        )
    };
    let text = format!(
        "name = \"test\"\n{}{}",
        block("native", "\"10ms\", \"20ms\""),
        block("chromium", "\"10ms\"")
    );
    fs::write(&experiment.file, text).unwrap();
    experiment
}

/// The command that runs it in its folder, where results get their default names.
fn begin(folder: &Path, arguments: &[&str], browser: &str) -> Command {
    let mut command = command();
    command
        .current_dir(folder)
        .args(["run", "experiment.toml"])
        .args(arguments)
        .env(BROWSER, browser);
    command
}

fn run(folder: &Path, arguments: &[&str], browser: &str) -> Output {
    begin(folder, arguments, browser).output().unwrap()
}

/// The results folders in `folder`.
fn results(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("results")).into_iter().flatten();
    entries.flatten().map(|entry| entry.path()).collect()
}

/// The cells that have ended, whatever the verdict; a try that a busy machine disturbed is none.
fn ended(out: &Path) -> Vec<PathBuf> {
    match out.join("cells").exists() {
        true => cells_of(out),
        false => Vec::new(),
    }
}
