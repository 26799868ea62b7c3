//! An honest campaign in virtual time, a copy of it to falsify, and what lies around.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use plan::Plan;
use record::FileFact;
use serde_json::Value;
use tempfile::TempDir;

use crate::ended::{Ended, ended};

/// Two links and two systems: a second of each at 100 Hz.
const EXPERIMENT: &str = "name = \"mine\"\n\
[[cells]]\n\
topology = [\"arima\", \"couva\"]\n\
system = [\"motor\", \"lag\"]\n\
client = [\"native\"]\n\
mode = \"closed\"\n\
h = [\"10ms\"]\n\
duration = \"1s\"\n";

/// Everything that prints a figure of a folder, or believes one that is there.
pub(crate) const COMMANDS: [&str; 12] = [
    "show",
    "show --format csv",
    "show --format lateness",
    "show --format intervals",
    "compare",
    "compare back",
    "agree",
    "collect",
    "calibrate",
    "report",
    "run --resume",
    "run-cell",
];

/// Those of them that write into it.
pub(crate) const WRITING: [&str; 3] = ["report", "run --resume", "run-cell"];

/// Those that go on with a folder.
pub(crate) const VERSIONED: [&str; 2] = ["run --resume", "run-cell"];

/// The folder that is falsified, as one that `run` named.
const VICTIM: &str = "results/mine-20261121-041503-s1";

/// A place with an honest folder, one to falsify, and somebody else's files.
pub(crate) struct Place {
    place: TempDir,
    plan: Plan,
}

/// A copy of the honest folder.
pub(crate) struct Victim {
    pub(crate) folder: PathBuf,
    /// The cell over a link, with the paper's system.
    pub(crate) cell: PathBuf,
    /// Another.
    pub(crate) other: PathBuf,
}

impl Place {
    pub(crate) fn new() -> Place {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("mine.toml"), EXPERIMENT).unwrap();
        let run = ["run", "mine.toml", "--backend", "sim", "--out", "honest"];
        let ended = ended(webloop().args(run).current_dir(place.path()));
        assert_eq!(ended.code, Some(0), "{}", ended.said);
        let text = fs::read_to_string(place.path().join("honest/plan.json")).unwrap();
        let plan = Plan::from_json(&text).unwrap();
        let outside = place.path().join("outside");
        fs::create_dir(&outside).unwrap();
        fs::write(outside.join("decoy"), "theirs").unwrap();
        Place { place, plan }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    fn index(&self) -> usize {
        let is_it = |cell: &plan::Cell| cell.topology == "couva" && cell.system == "motor";
        self.plan.cells.iter().position(is_it).unwrap()
    }

    pub(crate) fn cell_id(&self) -> &str {
        &self.plan.cells[self.index()].id
    }

    /// A new copy in the place of the last.
    pub(crate) fn victim(&self) -> Victim {
        let folder = self.path(VICTIM);
        let _ = fs::remove_dir_all(self.path("results"));
        let _ = fs::remove_dir_all(self.path("collected"));
        copy(&self.path("honest"), &folder);
        let cell = |index: usize| folder.join(self.plan.cells[index].folder());
        let other = (self.index() + 1) % self.plan.cells.len();
        Victim {
            cell: cell(self.index()),
            other: cell(other),
            folder,
        }
    }

    /// All that is not the victim's, nor asked for.
    pub(crate) fn outside(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![self.place.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let (path, kind) = (entry.path(), entry.file_type().unwrap());
                let is_asked = ["collected", "timings.toml", VICTIM]
                    .iter()
                    .any(|name| path == self.path(name));
                if is_asked {
                    continue;
                }
                let content = kind.is_file().then(|| fs::read(&path).unwrap());
                if kind.is_dir() {
                    folders.push(path.clone());
                }
                files.insert(path, content);
            }
        }
        files
    }

    pub(crate) fn run(&self, command: &str) -> Ended {
        let index = self.index().to_string();
        let plan = format!("{VICTIM}/plan.json");
        let run = ["run", "mine.toml", "--progress", "quiet", "--backend"];
        let cell = [
            "run-cell",
            "--plan",
            &plan,
            "--index",
            &index,
            "--out",
            VICTIM,
            "--backend",
        ];
        let arguments: Vec<&str> = match command {
            "show" | "report" => vec![command, VICTIM],
            "show --format csv" => vec!["show", VICTIM, "--format", "csv"],
            "show --format lateness" => vec!["show", VICTIM, "--format", "lateness"],
            "show --format intervals" => vec!["show", VICTIM, "--format", "intervals"],
            "compare" | "agree" => vec![command, "honest", VICTIM],
            "compare back" => vec!["compare", VICTIM, "honest"],
            "compare --allow-missing" => vec!["compare", "honest", VICTIM, "--allow-missing"],
            "agree --allow-missing" => vec!["agree", "honest", VICTIM, "--allow-missing"],
            "collect" => vec![command, VICTIM, "--out", "collected"],
            "calibrate" => vec![command, VICTIM, "--out", "timings.toml"],
            "run --resume" => [&run[..], &["sim", "--resume"]].concat(),
            "run --failed" => [&run[..], &["sim", "--failed"]].concat(),
            "run by netns" => [&run[..], &["netns", "--resume"]].concat(),
            "run by netns and tc" => [&run[..], &["netns", "--resume", "--player", "tc"]].concat(),
            "run-cell" => [&cell[..], &["sim"]].concat(),
            "run-cell by netns" => [&cell[..], &["netns"]].concat(),
            other => panic!("{other} is no command here"),
        };
        ended(webloop().args(&arguments).current_dir(self.place.path()))
    }
}

impl Victim {
    pub(crate) fn plan(&self) -> PathBuf {
        self.folder.join("plan.json")
    }

    pub(crate) fn manifest(&self) -> PathBuf {
        self.cell.join("manifest.json")
    }

    /// Those of all cells.
    pub(crate) fn manifests(&self) -> Vec<PathBuf> {
        let cells = fs::read_dir(self.folder.join("cells")).unwrap();
        cells
            .map(|cell| cell.unwrap().path().join("manifest.json"))
            .collect()
    }

    /// Brings the manifest's checksum of a file up to it, as an adversary can.
    pub(crate) fn seal(&self, name: &str) {
        let fact = FileFact::of(File::open(self.cell.join(name)).unwrap()).unwrap();
        edit_json(&self.manifest(), |manifest| {
            manifest["files"][name] = serde_json::to_value(&fact).unwrap();
        });
    }
}

/// Changes a file's text.
pub(crate) fn edit(path: &Path, change: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(path).unwrap();
    fs::write(path, change(text)).unwrap();
}

/// Changes a file's JSON.
pub(crate) fn edit_json(path: &Path, change: impl FnOnce(&mut Value)) {
    let mut json = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    change(&mut json);
    fs::write(path, serde_json::to_string_pretty(&json).unwrap() + "\n").unwrap();
}

/// Copies a folder with what is in it.
pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

fn webloop() -> Command {
    Command::new(env!("CARGO_BIN_EXE_webloop"))
}
