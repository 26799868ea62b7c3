//! The program as its users see it: a command with arguments, a folder with results.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use plan::{Plan, Verdict};
use record::Manifest;

/// A link to run over. It has a delay and losses, so that there is a fate to predict for each echo.
const OFFICE: &str = "name = \"office\"\nabout = \"5 ms and a little loss each way\"\n
[both.delay]\nbase = \"5ms\"\n
[both.loss.random]\nshare = \"2%\"\n";

/// Whether a run is not complete because of the machine, or of something else on it. If not even
/// the empty link could be measured in time, the run failed.
pub(crate) fn was_busy(manifest: &Manifest) -> bool {
    let reasons = || manifest.reasons.join("; ");
    match manifest.verdict {
        Verdict::Invalid | Verdict::Disturbed => true,
        Verdict::Failed => reasons().contains("too busy"),
        _ => false,
    }
}

/// Why a test cannot be made: the machine was busy each time.
pub(crate) fn too_busy(for_what: &str) -> String {
    format!("the machine was too busy for {for_what} each time")
}

/// The program that this test was built with, without the settings of the tester's own shell.
pub(crate) fn command() -> Command {
    command_of(Path::new(env!("CARGO_BIN_EXE_webloop")))
}

/// The same for a copy of the program elsewhere.
pub(crate) fn command_of(program: &Path) -> Command {
    let mut command = Command::new(program);
    command
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// What `webloop doctor` reports as missing, if this machine lacks anything that a run needs.
pub(crate) fn doctor(mut command: Command) -> Result<(), String> {
    let output = command.arg("doctor").output().unwrap();
    match output.status.code() {
        Some(0) => Ok(()),
        Some(3) => Err(String::from_utf8_lossy(&output.stdout).into_owned()),
        other => panic!("doctor ended with {other:?}: {}", said(&output)),
    }
}

/// An experiment and its profile in a folder, and where its results go.
pub(crate) struct Experiment {
    pub(crate) file: PathBuf,
    pub(crate) out: PathBuf,
}

impl Experiment {
    /// A closed loop over `topologies`; `office` is our own profile.
    pub(crate) fn new(folder: &Path, topologies: &[&str], h: &str, duration: &str) -> Self {
        let profile = folder.join("office.toml");
        fs::write(&profile, OFFICE).unwrap();
        let topologies: Vec<_> = topologies
            .iter()
            .map(|name| match *name {
                "office" => profile.display().to_string(),
                name => name.to_owned(),
            })
            .collect();
        let file = folder.join("experiment.toml");
        let text = format!(
            "name = \"test\"\n[[cells]]\ntopology = {topologies:?}\nclient = [\"native\"]\n\
             mode = \"closed\"\nh = [\"{h}\"]\nduration = \"{duration}\"\n"
        );
        fs::write(&file, text).unwrap();
        Experiment {
            file,
            out: folder.join("out"),
        }
    }

    /// The same with this number of repeats.
    #[allow(dead_code)] // One of the two test programs that share this file needs it.
    pub(crate) fn repeated(self, repeats: usize) -> Self {
        let text = fs::read_to_string(&self.file).unwrap();
        fs::write(&self.file, format!("{text}repeats = {repeats}\n")).unwrap();
        self
    }

    /// Adds the arguments that run this experiment to `command`.
    pub(crate) fn run(&self, mut command: Command) -> Command {
        command.arg("run").arg(&self.file).arg("--out");
        command.arg(&self.out);
        command
    }

    /// Runs it until it is complete, for as long as [`serial::tries`] lasts.
    ///
    /// A machine that is busy with something else can be too late for the link, which makes a run
    /// `invalid`, or hold up a part of it, which makes it `disturbed`. webloop must then report
    /// that, and asking again must give a new run. A machine that is busy each time is an error.
    pub(crate) fn complete(&self) -> Result<Output, String> {
        for _ in serial::tries() {
            let output = self.run(command()).output().unwrap();
            let manifests: Vec<_> = self.cells().iter().map(|cell| manifest(cell)).collect();
            let busy = manifests
                .iter()
                .filter(|manifest| was_busy(manifest))
                .inspect(|manifest| println!("  too busy: {:?}", manifest.reasons))
                .count();
            if busy == 0 {
                return Ok(output);
            }
            assert_eq!(code(&output), Some(1), "{}", said(&output));
        }
        Err(too_busy("this run"))
    }

    pub(crate) fn plan(&self) -> Plan {
        Plan::from_json(&fs::read_to_string(self.out.join("plan.json")).unwrap()).unwrap()
    }

    /// The folder of each cell, in order.
    pub(crate) fn cells(&self) -> Vec<PathBuf> {
        let plan = self.plan();
        plan.cells
            .iter()
            .map(|cell| backend::cell_folder(&self.out, cell))
            .collect()
    }
}

/// Runs an experiment's file on a back-end until no cell of it was disturbed; the cells' manifests.
pub(crate) fn run_undisturbed(
    file: &Path,
    out: &Path,
    backend: &str,
) -> Result<Vec<Manifest>, String> {
    run_together(file, out, backend, 1)
}

/// The same with so many cells at a time. Those that were disturbed run again, alone.
pub(crate) fn run_together(
    file: &Path,
    out: &Path,
    backend: &str,
    jobs: usize,
) -> Result<Vec<Manifest>, String> {
    for _ in serial::tries() {
        let mut run = command();
        run.arg("run")
            .arg(file)
            .args(["--backend", backend, "--out"]);
        run.arg(out);
        if out.exists() {
            run.arg("--failed");
        } else if jobs > 1 {
            run.args(["--jobs", &jobs.to_string()]);
        }
        let output = run.output().unwrap();
        assert!(matches!(code(&output), Some(0 | 1)), "{}", said(&output));
        let manifests: Vec<_> = cells_of(out).iter().map(|cell| manifest(cell)).collect();
        let mut busy = manifests
            .iter()
            .filter(|manifest| was_busy(manifest))
            .peekable();
        if busy.peek().is_none() {
            return Ok(manifests);
        }
        busy.for_each(|manifest| println!("  too busy: {:?}", manifest.reasons));
    }
    Err(too_busy("this run"))
}

/// The folders of a campaign's cells that have ended, without those of tries that were made again.
pub(crate) fn cells_of(out: &Path) -> Vec<PathBuf> {
    let cells = fs::read_dir(out.join("cells")).unwrap().flatten();
    // An earlier try's folder has its number after a point.
    cells
        .filter(|cell| !cell.file_name().to_string_lossy().contains('.'))
        .map(|cell| cell.path())
        .filter(|cell| cell.join(Manifest::FILE).exists())
        .collect()
}

/// A cell's manifest.
pub(crate) fn manifest(cell: &Path) -> Manifest {
    Manifest::from_json(&fs::read_to_string(cell.join(Manifest::FILE)).unwrap()).unwrap()
}

/// Every file of a folder, by name; empty if there is no folder.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = fs::read_dir(folder) else {
        return BTreeMap::new();
    };
    entries
        .flatten()
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()))
        .map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, fs::read(entry.path()).unwrap())
        })
        .collect()
}

/// A column of a CSV file, without a torn last line.
pub(crate) fn column(csv: &[u8], name: &str) -> Vec<String> {
    let text = std::str::from_utf8(csv).unwrap();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let mut lines = whole.lines();
    let header = lines.next().unwrap_or("");
    let at = header.split(',').position(|word| word == name);
    let Some(at) = at else {
        assert!(header.is_empty(), "no column {name} in {header}");
        return Vec::new();
    };
    lines
        .map(|line| line.split(',').nth(at).unwrap().to_owned())
        .collect()
}

/// Everything that a finished program printed, for error texts and for searching.
pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// The exit code, after a check that nothing panicked.
pub(crate) fn code(output: &Output) -> Option<i32> {
    assert!(!said(output).contains("panicked"), "{}", said(output));
    output.status.code()
}
