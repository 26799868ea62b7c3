//! A run that goes well, and what its folder alone shows afterwards.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use endpoint::Counts;
use link::certificate::Verdict::Holds;
use plan::Verdict;
use record::Manifest;
use record::{ControllerReport, PlantReport};
use sha2::{Digest, Sha256};

use crate::webloop::{Experiment, code, column, command, files, manifest, said};

/// Deadlines of a run of 1.5 s with h = 3 ms: one each h, the first at once.
const DUE: u64 = 500;

pub(crate) fn a_run_leaves_a_folder_that_proves_itself_and_is_not_made_twice() -> Result<(), String>
{
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["arima", "office"], "3ms", "1.5s");
    let first = experiment.complete()?;
    assert_eq!(code(&first), Some(0), "{}", said(&first));
    for cell in experiment.cells() {
        let manifest = manifest(&cell);
        assert_eq!(manifest.verdict, Verdict::Complete);
        came_to_its_end(&manifest);
        every_row_is_counted(&manifest, &cell);
        checksums_hold(&manifest, &cell);
    }

    let shown = command().arg("show").arg(&experiment.out).output().unwrap();
    assert_eq!(code(&shown), Some(0), "{}", said(&shown));
    let table = String::from_utf8(shown.stdout).unwrap();
    let printed = String::from_utf8(first.stdout).unwrap();
    assert!(printed.starts_with(&table), "{printed}\nbut show:\n{table}");
    for topology in ["arima", "office"] {
        assert!(table.contains(topology), "{table}");
    }

    // A cell that is run takes at least its 1.5 s; two that are not run take some ms.
    let (before, started) = (state(&experiment), Instant::now());
    let again = experiment.run(command()).output().unwrap();
    assert!(started.elapsed() < Duration::from_millis(1_500));
    assert_eq!(code(&again), Some(0), "{}", said(&again));
    assert_eq!(String::from_utf8(again.stdout).unwrap(), printed);
    assert_eq!(state(&experiment), before);

    let other = experiment
        .run(command())
        .args(["--seed", "2"])
        .output()
        .unwrap();
    assert_eq!(code(&other), Some(2), "{}", said(&other));
    assert!(said(&other).contains("another plan"), "{}", said(&other));
    assert_eq!(state(&experiment), before);
    Ok(())
}

/// Checks, even on a busy machine, that each process came to its end and each echo met its fate.
pub(crate) fn came_to_its_end(manifest: &Manifest) {
    let (verdict, reasons) = (manifest.verdict, &manifest.reasons);
    assert!(
        matches!(
            verdict,
            Verdict::Complete | Verdict::Disturbed | Verdict::Invalid
        ),
        "{verdict}: {reasons:?}"
    );
    let certificate = manifest.certificate.as_ref().expect("echoes were judged");
    assert!(manifest.messages.is_some() && manifest.pulse.is_some());
    if manifest.player == "none" {
        return;
    }
    assert_eq!(manifest.player, "user");
    let held = certificate.verdict == Holds;
    assert!(held || verdict != Verdict::Complete, "{certificate:?}");
    // Which echo is lost depends on the seed and not on time.
    assert_eq!(certificate.fates.came_though_lost, 0, "{certificate:?}");
    // 50 before, 10 a second during and 50 after. 2 % each way lose 4 % of 115 echoes, 4.6 +- 2.1;
    // five deviations more are 15.
    let (sent, due) = (
        certificate.sent as u64,
        100 + manifest.cell.duration_ns / 100_000_000,
    );
    // A machine that stood still as one was due has left it out.
    assert!(
        sent == due || sent < due && verdict != Verdict::Complete,
        "{sent} of {due}: {reasons:?}"
    );
    assert!(certificate.answered as u64 + 15 >= sent);
}

/// Checks that due = sent + missed, each with a row, and that the plant wrote what it counted.
fn every_row_is_counted(manifest: &Manifest, cell: &Path) {
    let plant = manifest.plant.as_ref().and_then(PlantReport::real);
    let plant = plant.expect("it leaves its report");
    let controller = manifest.controller.as_ref();
    let counts = controller.and_then(ControllerReport::counts);
    let rows = |file: &str, name: &str| column(&fs::read(cell.join(file)).unwrap(), name);
    let Counts {
        sent,
        missed,
        answered,
        ..
    } = *counts.expect("it leaves its report");
    assert_eq!(sent + missed, DUE);
    let outcomes = rows("messages.csv", "outcome");
    let of = |word: &str| outcomes.iter().filter(|outcome| *outcome == word).count() as u64;
    assert_eq!(outcomes.len() as u64, DUE);
    assert_eq!(of("missed"), missed);
    assert_eq!(of("answered"), answered);
    assert!(answered > 0);
    let ticks = rows("ticks.csv", "k").len() as u64;
    assert_eq!(ticks, plant.ticks);
    let arrivals = rows("arrivals.csv", "n").len() as u64;
    assert_eq!(arrivals, plant.arrivals);
    assert!(answered <= arrivals && arrivals <= sent);
}

fn checksums_hold(manifest: &Manifest, cell: &Path) {
    let mut files = files(cell);
    files.remove(Manifest::FILE);
    assert!(files.keys().eq(manifest.files.keys()), "{:?}", files.keys());
    for (name, content) in files {
        let fact = &manifest.files[&name];
        let sha256 = Sha256::digest(&content)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect::<String>();
        assert_eq!(
            (fact.bytes, &fact.sha256),
            (content.len() as u64, &sha256),
            "{name}"
        );
    }
}

/// Everything in the folders of the cells, to check that nothing was touched.
fn state(experiment: &Experiment) -> Vec<impl PartialEq + std::fmt::Debug> {
    let cells = fs::read_dir(experiment.out.join("cells"))
        .unwrap()
        .flatten();
    let mut state: Vec<_> = cells
        .map(|cell| (cell.file_name(), files(&cell.path())))
        .collect();
    state.sort();
    state
}
