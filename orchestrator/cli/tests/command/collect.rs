//! Merges results folders of one plan: whole cells, in whatever order, and only checked ones.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use plan::{Cell, Instead, Plan, ProfileText, Verdict};
use record::{FileFact, Manifest};
use tempfile::TempDir;

/// A second of an open loop at 10 Hz: the rows of each cell in these tests.
const RAN: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/cmd/input/ran/cells/arima-native-open-10hz-r01-000001"
);

/// What such a run leaves beside its link's profile.
const FILES: [&str; 6] = [
    "ticks.csv",
    "arrivals.csv",
    "messages.csv",
    "probes.csv",
    "plant.json",
    "controller.json",
];

/// An experiment of four cells.
fn plan(seed: u64) -> Plan {
    let source = format!(
        "name = \"mine\"\nseed = {seed}\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\n\
         mode = \"open\"\nh = [\"100ms\"]\nduration = \"1s\"\nrepeats = 4\n"
    );
    let profile = |name: &str| {
        let source = link::Profile::builtin(name).expect("built in").to_owned();
        Ok(ProfileText {
            source,
            ..ProfileText::default()
        })
    };
    Plan::resolve(&source, "mine.toml", &Instead::default(), profile).expect("an experiment")
}

/// A folder for results folders, removed afterwards.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A results folder with these runs, each begun at its `second` of a minute.
    fn results(&self, name: &str, runs: &[(usize, Verdict, u32)]) -> PathBuf {
        self.results_of(&plan(1), name, runs)
    }

    fn results_of(&self, plan: &Plan, name: &str, runs: &[(usize, Verdict, u32)]) -> PathBuf {
        let folder = self.path(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("plan.json"), plan.to_json()).unwrap();
        for (index, verdict, second) in runs {
            leave(plan, &folder, plan.cell(*index).unwrap(), *verdict, *second);
        }
        folder
    }

    fn collect(&self, folders: &[&Path], out: &str) -> Collected {
        let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
            .arg("collect")
            .args(folders)
            .arg("--out")
            .arg(self.path(out))
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        Collected::of(&output)
    }
}

/// Writes a run as a back-end leaves it.
fn leave(plan: &Plan, campaign: &Path, cell: &Cell, verdict: Verdict, second: u32) {
    let folder = campaign.join(cell.folder());
    fs::create_dir_all(&folder).unwrap();
    let ran = Path::new(RAN);
    for name in FILES {
        fs::copy(ran.join(name), folder.join(name)).unwrap();
    }
    fs::write(folder.join("plant.log"), format!("second {second}\n")).unwrap();
    let profile = &plan.profiles[&cell.topology].source;
    fs::write(folder.join("profile.toml"), profile).unwrap();
    let text = fs::read_to_string(ran.join(Manifest::FILE)).unwrap();
    let names = FILES.iter().chain(&["plant.log", "profile.toml"]);
    let manifest = Manifest {
        verdict,
        experiment: plan.experiment.clone(),
        campaign_seed: plan.seed,
        cell: cell.clone(),
        started: format!("2026-01-01T00:00:{second:02}Z"),
        files: names
            .map(|name| {
                let fact = FileFact::of(File::open(folder.join(name)).unwrap()).unwrap();
                ((*name).to_owned(), fact)
            })
            .collect(),
        ..Manifest::from_json(&text).unwrap()
    };
    fs::write(folder.join(Manifest::FILE), manifest.to_json()).unwrap();
}

/// How `webloop collect` ended.
struct Collected {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Collected {
    fn of(output: &Output) -> Collected {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let collected = Collected {
            code: output.status.code(),
            out: text(&output.stdout),
            err: text(&output.stderr),
        };
        assert!(!collected.err.contains("panicked"), "{}", collected.err);
        collected
    }

    #[track_caller]
    fn ended_with(self, code: i32) -> Collected {
        assert_eq!(self.code, Some(code), "{}{}", self.out, self.err);
        self
    }
}

/// Every file below a folder, by its path.
fn state(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                files.insert(name, fs::read(path).unwrap());
            }
        }
    }
    files
}

fn cell(index: usize) -> PathBuf {
    plan(1).cell(index).unwrap().folder()
}

const DONE: Verdict = Verdict::Complete;

#[test]
fn in_whatever_order_the_same_bytes_come_of_it_and_the_second_time_nothing() {
    let place = Place::new();
    let a = place.results(
        "a",
        &[
            (0, DONE, 1),
            (1, Verdict::Failed, 9),
            (2, Verdict::Invalid, 3),
        ],
    );
    let b = place.results("b", &[(1, DONE, 2), (2, Verdict::Invalid, 5), (3, DONE, 4)]);
    let there = place.collect(&[&a, &b], "there").ended_with(1);
    place.collect(&[&b, &a], "back").ended_with(1);
    let merged = state(&place.path("there"));
    assert_eq!(merged, state(&place.path("back")));
    assert!(
        there
            .out
            .contains("4 cells copied, 0 left as they were, of 4"),
        "{}",
        there.out
    );

    // A complete run is taken before a failed one, and the later of two invalid ones; each file as
    // it was.
    for (index, from) in [(0, &a), (1, &b), (2, &b), (3, &b)] {
        for (name, content) in state(&from.join(cell(index))) {
            assert_eq!(merged[&cell(index).join(name)], content);
        }
    }
    assert!(there.out.contains("Invalid:\n   2  arima"), "{}", there.out);
    assert!(merged.contains_key(Path::new("summary.csv")));
    assert!(merged.contains_key(Path::new("table.txt")));

    let again = place
        .collect(&[&b, &place.path("there"), &a], "there")
        .ended_with(1);
    assert_eq!(state(&place.path("there")), merged);
    assert!(
        again.out.contains("0 cells copied, 4 left as they were"),
        "{}",
        again.out
    );
}

#[test]
fn folders_in_a_folder_are_found_and_a_whole_plan_is_fine() {
    let place = Place::new();
    place.results("jobs/results-2", &[(2, DONE, 1), (3, DONE, 2)]);
    place.results("jobs/results-1", &[(0, DONE, 3), (1, DONE, 4)]);
    fs::create_dir_all(place.path("jobs/logs")).unwrap();
    let collected = place.collect(&[&place.path("jobs")], "out").ended_with(0);
    for list in ["Not run", "Invalid", "Failed", "webloop run"] {
        assert!(!collected.out.contains(list), "{}", collected.out);
    }
    let table = fs::read_to_string(place.path("out/table.txt")).unwrap();
    assert!(!table.contains("have not been run"), "{table}");
}

#[test]
fn what_is_missing_is_listed_with_how_to_run_it() {
    let place = Place::new();
    let a = place.results("a", &[(0, DONE, 1), (3, DONE, 2)]);
    let collected = place.collect(&[&a], "out").ended_with(1);
    let plan = plan(1);
    for index in [1, 2] {
        assert!(
            collected.out.contains(&plan.cells[index].id),
            "{}",
            collected.out
        );
    }
    assert!(
        !collected.out.contains(&plan.cells[3].id),
        "{}",
        collected.out
    );
    let out = place.path("out").display().to_string();
    let remedy = format!("webloop run {out}/plan.json --out {out}");
    assert!(collected.out.contains(&remedy), "{}", collected.out);
}

#[test]
fn two_complete_runs_of_a_cell_are_refused_and_both_named() {
    let place = Place::new();
    let a = place.results("a", &[(0, DONE, 1), (1, DONE, 2)]);
    let b = place.results("b", &[(0, DONE, 1), (1, DONE, 3)]);
    let refused = place.collect(&[&a, &b], "out").ended_with(2);
    for folder in [&a, &b] {
        let named = folder.join(cell(1)).display().to_string();
        assert!(refused.err.contains(&named), "{}", refused.err);
    }
    assert!(!place.path("out/cells").exists());
}

#[test]
fn a_changed_byte_is_found_and_named_and_that_cell_is_not_taken() {
    let place = Place::new();
    let a = place.results("a", &[(0, DONE, 1), (1, DONE, 2)]);
    let b = place.results("b", &[(1, DONE, 2)]);
    let ticks = a.join(cell(1)).join("ticks.csv");
    let mut bytes = fs::read(&ticks).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&ticks, bytes).unwrap();

    let collected = place.collect(&[&a], "out").ended_with(1);
    assert!(
        collected.err.contains(&ticks.display().to_string()),
        "{}",
        collected.err
    );
    assert!(collected.err.contains("checksum"), "{}", collected.err);
    assert!(place.path("out").join(cell(0)).exists());
    assert!(!place.path("out").join(cell(1)).exists());

    // A whole copy of the same run is as good; the damaged one is still reported.
    let healed = place.collect(&[&a, &b], "out").ended_with(1);
    assert!(healed.err.contains("checksum"), "{}", healed.err);
    let taken = state(&place.path("out").join(cell(1)));
    assert_eq!(taken, state(&b.join(cell(1))));
}

#[test]
fn a_complete_run_takes_the_place_of_what_is_moved_aside() {
    let place = Place::new();
    let own = place.results("own", &[(0, Verdict::Failed, 9)]);
    // What a killed run left, and what a killed `collect` left.
    fs::create_dir_all(own.join(cell(1))).unwrap();
    fs::write(own.join(cell(1)).join("ticks.csv"), "torn").unwrap();
    let partial = format!("{}.partial", own.join(cell(1)).display());
    fs::create_dir_all(&partial).unwrap();
    fs::write(Path::new(&partial).join("half"), "a file").unwrap();
    let failed = state(&own.join(cell(0)));

    let other = place.results("other", &[(0, DONE, 1), (1, DONE, 2)]);
    place.collect(&[&own, &other], "own").ended_with(1);
    for index in [0, 1] {
        assert_eq!(
            state(&own.join(cell(index))),
            state(&other.join(cell(index)))
        );
    }
    let aside = |index| PathBuf::from(format!("{}.unfinished-1", own.join(cell(index)).display()));
    assert_eq!(state(&aside(0)), failed);
    assert_eq!(
        fs::read_to_string(aside(1).join("ticks.csv")).unwrap(),
        "torn"
    );
    assert!(!Path::new(&partial).exists());
}

#[test]
fn folders_of_different_plans_are_refused_with_the_first_difference() {
    let place = Place::new();
    let a = place.results("a", &[(0, DONE, 1)]);
    let b = place.results_of(&plan(2), "b", &[]);
    for (folders, out) in [(vec![a.as_path(), &b], "out"), (vec![a.as_path()], "b")] {
        let refused = place.collect(&folders, out).ended_with(2);
        for words in [
            a.display().to_string(),
            b.display().to_string(),
            "seed 1 and seed 2".to_owned(),
        ] {
            assert!(refused.err.contains(&words), "{}", refused.err);
        }
    }
    assert!(!place.path("out").exists());
    assert!(!b.join("cells").exists());
}

#[test]
fn a_manifest_that_reaches_beyond_its_folder_or_is_none_is_not_followed() {
    let place = Place::new();
    let a = place.results("a", &[(0, DONE, 1), (1, DONE, 2), (2, DONE, 3)]);
    let manifest = |index: usize| a.join(cell(index)).join(Manifest::FILE);
    let text = fs::read_to_string(manifest(0)).unwrap();
    fs::write(manifest(0), text.replace("plant.log", "../../plan.json")).unwrap();
    fs::write(manifest(1), "{}").unwrap();
    // Another cell's run, in the folder of this one.
    fs::copy(
        manifest(0).with_file_name("ticks.csv"),
        manifest(2).with_file_name("ticks.csv"),
    )
    .unwrap();
    let other = fs::read_to_string(manifest(2))
        .unwrap()
        .replace("\"repeat\": 3", "\"repeat\": 2");
    fs::write(manifest(2), other).unwrap();

    let collected = place.collect(&[&a], "out").ended_with(1);
    for index in 0..3 {
        let named = manifest(index).display().to_string();
        assert!(collected.err.contains(&named), "{}", collected.err);
        assert!(!place.path("out").join(cell(index)).exists());
    }
}
