//! Runs a cell and disturbs it meanwhile.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use plan::Plan;
use serde_json::Value;
use tempfile::TempDir;

use crate::effect::Effect;
use crate::player::OtherPlayer;
use crate::sabotage::Sabotage;
use crate::target::{NOT_THERE, Target};

/// Gives a wired link a rate that is wide enough for the loop.
const NARROW: &str = "
[both]
rate = \"2mbit\"
";

/// A seed that no plan has by chance.
const OTHER_SEED: &str = "4711";

/// Cells that differ only in their links' seeds.
pub(crate) struct Series {
    folder: TempDir,
    plan: Plan,
}

/// Settings of a series.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    /// A built-in topology, the path of a profile, or `narrow`.
    pub(crate) topology: String,
    /// A built-in one, or a program as experiments write it.
    pub(crate) client: String,
    /// `keep`, or `new` for each message.
    pub(crate) connection: &'static str,
    pub(crate) h: String,
    pub(crate) duration: String,
    pub(crate) times: usize,
}

/// Outcome of a cell.
pub(crate) struct Outcome {
    pub(crate) verdict: String,
    pub(crate) reasons: Vec<String>,
    /// What was done to it, in numbers, or why it could not be done.
    pub(crate) done: Result<String, String>,
    /// What its rows show, or why they cannot be read.
    pub(crate) effect: Result<Effect, String>,
}

impl Series {
    /// Makes the plan, with webloop itself.
    pub(crate) fn new(setup: &Setup) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|problem| problem.to_string())?;
        let topology = match setup.topology.as_str() {
            "narrow" => narrow(folder.path()),
            other => match fs::canonicalize(other) {
                Ok(path) => path.display().to_string(),
                Err(_) => other.to_owned(),
            },
        };
        let (experiment, plan) = (
            folder.path().join("test.toml"),
            folder.path().join("plan.json"),
        );
        let client = if setup.client.starts_with('{') {
            stranger(folder.path())?;
            setup.client.clone()
        } else {
            format!("{:?}", setup.client)
        };
        let text = format!(
            "name = \"sabotage\"\n[[cells]]\ntopology = [{topology:?}]\nclient = [{client}]\n\
             mode = \"closed\"\nconnection = {:?}\nh = [{:?}]\nduration = {:?}\nrepeats = {}\n",
            setup.connection, setup.h, setup.duration, setup.times
        );
        fs::write(&experiment, text).unwrap();
        let output = crate::webloop::command()
            .arg("matrix")
            .arg(&experiment)
            .arg("--plan")
            .arg(&plan)
            .output()
            .unwrap();
        if !output.status.success() {
            return Err(crate::webloop::said(&output));
        }
        let plan = Plan::from_json(&fs::read_to_string(plan).unwrap())
            .map_err(|wrong| wrong.to_string())?;
        Ok(Self { folder, plan })
    }

    /// Runs one of its cells, from 0, under `sabotage`.
    pub(crate) fn run(&self, index: usize, sabotage: &Sabotage) -> Outcome {
        let cell = &self.plan.cells[index];
        let out = self.folder.path().join(format!("out-{index}"));
        let folder = backend::cell_folder(&out, cell);
        let ended = AtomicBool::new(false);
        let (done, said) = thread::scope(|scope| {
            let saboteur = scope.spawn(|| {
                let target = Target::find(&folder, cell.duration_ns, &ended)?;
                sabotage.perform(&target)
            });
            // On a thread of its own, whose view of the machine's files may differ.
            let cell = scope.spawn(|| {
                let said = self.run_cell(index, &out, sabotage);
                ended.store(true, Ordering::Relaxed);
                said
            });
            let said = joined(cell);
            (joined(saboteur), said)
        });
        let said = match said {
            Ok(said) => said,
            Err(problem) => return Outcome::none(problem),
        };
        let Ok(text) = fs::read_to_string(folder.join("manifest.json")) else {
            return Outcome::none(format!("no manifest: {said}"));
        };
        // Not read as plan's own type, which may not know all verdicts.
        let manifest: Value = serde_json::from_str(&text).unwrap();
        let reasons = manifest["reasons"].as_array().into_iter().flatten();
        let epoch_ns = manifest["epoch_ns"].as_u64().unwrap_or(0);
        let outcome = Outcome {
            verdict: manifest["verdict"].as_str().unwrap_or("none").to_owned(),
            reasons: reasons
                .filter_map(|reason| reason.as_str().map(str::to_owned))
                .collect(),
            done,
            effect: Effect::read(&self.plan, cell, &folder, epoch_ns),
        };
        let is_found = outcome
            .done
            .as_ref()
            .err()
            .is_none_or(|said| said != NOT_THERE);
        assert!(
            outcome.has_failed() || is_found,
            "{NOT_THERE}, and yet it is {}",
            outcome.verdict
        );
        outcome
    }

    /// Runs the cell to its end. Returns what it printed.
    fn run_cell(&self, index: usize, out: &Path, sabotage: &Sabotage) -> Result<String, String> {
        let program = Path::new(env!("CARGO_BIN_EXE_webloop"));
        let folder = self.folder.path();
        let other = match sabotage {
            Sabotage::Seed => Some(OtherPlayer::with("seed", OTHER_SEED, program, folder)?),
            Sabotage::Rate(rate) => {
                let source = Value::from(self.with_rate(index, rate)).to_string();
                Some(OtherPlayer::with("source", &source, program, folder)?)
            }
            _ => None,
        };
        let program = other
            .as_ref()
            .map_or_else(|| program.to_owned(), OtherPlayer::program);
        let output = Command::new(program)
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .args(["run-cell", "--tries", "1"])
            .arg("--plan")
            .arg(self.plan_file())
            .args([
                "--index",
                &self.plan.cells[index].index.to_string(),
                "--out",
            ])
            .arg(out)
            .output()
            .map_err(|problem| format!("cannot start a cell: {problem}"))?;
        Ok(crate::webloop::said(&output))
    }

    /// A cell's profile with this rate; replaces its own rate if it has one.
    fn with_rate(&self, index: usize, rate: &str) -> String {
        let source = &self.plan.profiles[&self.plan.cells[index].topology].source;
        if source.contains(NARROW) {
            source.replace(NARROW, &narrow_to(rate))
        } else {
            source.clone() + &narrow_to(rate)
        }
    }

    fn plan_file(&self) -> PathBuf {
        self.folder.path().join("plan.json")
    }
}

impl Outcome {
    /// Whether the cell failed to run to its end, whatever was done to it.
    pub(crate) fn has_failed(&self) -> bool {
        ["failed", "none"].contains(&self.verdict.as_str())
    }

    /// Whether the host took processors away from it, by the kernel's count.
    pub(crate) fn is_host_s(&self) -> bool {
        let mut reasons = self.reasons.iter();
        self.verdict == "disturbed" && reasons.any(|reason| reason.contains("the host took"))
    }

    fn none(problem: String) -> Self {
        Self {
            verdict: "none".to_owned(),
            reasons: Vec::new(),
            done: Err(problem.clone()),
            effect: Err(problem),
        }
    }
}

/// The end of a profile that sets this rate.
fn narrow_to(rate: &str) -> String {
    NARROW.replace("2mbit", rate)
}

/// Writes a profile with a rate into `folder`.
fn narrow(folder: &Path) -> String {
    let buccoo = link::Profile::builtin("buccoo").unwrap();
    let text = buccoo.replace("name = \"buccoo\"", "name = \"narrow\"");
    let path = folder.join("narrow.toml");
    fs::write(&path, text + NARROW).unwrap();
    path.display().to_string()
}

/// Compiles the stranger in C into `folder`: a program in Python is too slow for h = 3 ms on a small machine.
fn stranger(folder: &Path) -> Result<(), String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/strangers/stranger.c");
    let mut compiler = Command::new("cc");
    compiler.arg("-O1").arg("-o").arg(folder.join("stranger"));
    match compiler.arg(source).status() {
        Ok(status) if status.success() => Ok(()),
        other => Err(format!("no C compiler made the stranger: {other:?}")),
    }
}

fn joined<T>(thread: thread::ScopedJoinHandle<'_, T>) -> T {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
