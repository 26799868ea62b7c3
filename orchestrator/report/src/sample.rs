//! Campaigns for tests: an experiment, with a given outcome for each of its cells.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use analysis::{Campaign, CellFacts, LinkFacts, LoopVerdict, Metrics, Run, Summary};
use link::Epoch;
use plan::{Cell, Instead, Plan, ProfileText, Verdict};
use record::{FileFact, Machine, Manifest};

/// The outcome of a cell.
pub(crate) enum Outcome {
    /// It is complete; its loop is stable and settled in this many ms.
    Stable(f64),
    /// It is complete; its loop is not stable.
    Lost(LoopVerdict),
    /// It did not run to its end, for this reason.
    Failed(&'static str),
    /// It has not been run.
    Absent,
}

/// A campaign of the cells in these lines of `[[cells]]`, with the outcome of each.
pub(crate) fn campaign(cells: &str, outcome: impl Fn(&Cell) -> Outcome) -> Campaign {
    let source = format!("name = \"mine\"\nabout = \"a sample\"\n{cells}");
    let profile = |name: &str| {
        let source = link::Profile::builtin(name).expect("built in").to_owned();
        Ok(ProfileText {
            source,
            ..ProfileText::default()
        })
    };
    let plan = Plan::resolve(&source, "mine.toml", &Instead::default(), profile)
        .expect("a valid experiment");
    let runs = plan.cells.iter().map(|cell| run(cell, &outcome(cell)));
    Campaign {
        folder: PathBuf::from("somewhere"),
        runs: runs.collect(),
        plan,
    }
}

fn run(cell: &Cell, outcome: &Outcome) -> Run {
    let verdict = match outcome {
        Outcome::Stable(_) | Outcome::Lost(_) => Some(Verdict::Complete),
        Outcome::Failed(_) => Some(Verdict::Failed),
        Outcome::Absent => None,
    };
    let metrics = (verdict == Some(Verdict::Complete)).then(|| no_rows(cell));
    let manifest = verdict.map(|verdict| manifest(cell, verdict, outcome));
    let mut summary = Summary::new(
        cell,
        manifest.as_ref(),
        LinkFacts::default(),
        metrics.as_ref(),
    );
    match outcome {
        Outcome::Stable(settling_ms) => {
            summary.loop_verdict = Some(LoopVerdict::Holds);
            summary.settling_ms = Some(*settling_ms);
        }
        Outcome::Lost(verdict) => summary.loop_verdict = Some(*verdict),
        Outcome::Failed(_) | Outcome::Absent => {}
    }
    Run {
        manifest,
        cell: cell.clone(),
        folder: PathBuf::from("somewhere").join(cell.folder()),
        metrics,
        recovery: None,
        summary,
        damage: Vec::new(),
    }
}

/// The metrics of empty files.
fn no_rows(cell: &Cell) -> Metrics {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["ticks.csv", "arrivals.csv", "messages.csv", "probes.csv"] {
        fs::write(folder.path().join(name), "").expect("a writable folder");
    }
    Metrics::read(folder.path(), &CellFacts::from(cell)).expect("empty files are read")
}

fn manifest(cell: &Cell, verdict: Verdict, outcome: &Outcome) -> Manifest {
    let fact = FileFact {
        bytes: 3,
        sha256: "ab".repeat(32),
    };
    Manifest {
        version: Manifest::VERSION,
        verdict,
        reasons: match outcome {
            Outcome::Failed(reason) => vec![(*reason).to_owned()],
            _ => Vec::new(),
        },
        disturbances: Vec::new(),
        earlier: Vec::new(),
        experiment: "mine".to_owned(),
        campaign_seed: 1,
        cell: cell.clone(),
        profile: cell.topology.clone(),
        backend: "netns".to_owned(),
        engine: None,
        player: "user".to_owned(),
        webloop: "0.1.0".to_owned(),
        machine: Machine {
            kernel: "Linux 6.1.0".to_owned(),
            architecture: "x86_64".to_owned(),
            processor: "A processor".to_owned(),
            cores: 2,
            memory_mib: 4096,
            clock_source: "tsc".to_owned(),
            awake: false,
        },
        authority: "privileged".to_owned(),
        started: "2026-01-01T00:00:00.123Z".to_owned(),
        wall_s: 4.0,
        epoch: Epoch::at_ns(0),
        start_ns: 0,
        messages: None,
        pulse: None,
        watched: None,
        end_faults: Vec::new(),
        ends: None,
        certificate: None,
        plant: None,
        controller: None,
        page: None,
        link: None,
        files: BTreeMap::from([("ticks.csv".to_owned(), fact)]),
    }
}
