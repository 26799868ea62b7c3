//! A results folder as it was left: its plan, and of each cell the manifest and what its rows say.
//!
//! A folder is read wherever it came from: a copy, a merge, a part. A cell that cannot be read is
//! one with a problem, and the others are read all the same. Nothing is written.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use plan::{Cell, FileFact, Manifest, Plan, Verdict};
use thiserror::Error;

use crate::metrics::{CellFacts, Metrics};
use crate::parallel;
use crate::summary::Summary;

/// The file that says what a results folder is for.
pub const PLAN: &str = "plan.json";

/// Why a folder is no results folder.
#[derive(Debug, Error)]
pub enum CampaignError {
    /// There is no plan, or it cannot be read.
    #[error("{path}: {source}; a results folder has a plan.json")]
    File {
        /// The plan's file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The plan is none.
    #[error("{path}: {problem}")]
    Plan {
        /// The plan's file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

/// A results folder, read.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// The folder.
    pub folder: PathBuf,
    /// What was to be run.
    pub plan: Plan,
    /// Every cell of the plan, in its order, run or not.
    pub runs: Vec<Run>,
}

/// One cell of a campaign.
#[derive(Debug, Clone)]
pub struct Run {
    /// The cell.
    pub cell: Cell,
    /// Its folder, which does not exist where it has not been run.
    pub folder: PathBuf,
    /// What the run says of itself; `None` where it has not been run.
    pub manifest: Option<Manifest>,
    /// What its rows say; `None` where there are none, or they cannot be read.
    pub metrics: Option<Metrics>,
    /// All of it in a row.
    pub summary: Summary,
    /// What kept the manifest or the rows from being read: file, line and remedy.
    pub problem: Option<String>,
}

impl Run {
    /// Whether it ran to its end over a link that held, and its rows can be read: what figures and
    /// claims are made of.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.verdict() == Some(Verdict::Complete) && self.metrics.is_some()
    }

    /// How it ended; `None` where it has not been run.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.manifest.as_ref().map(|manifest| manifest.verdict)
    }
}

impl Campaign {
    /// Reads a folder with everything in it.
    ///
    /// # Errors
    /// [`CampaignError`] where it is no results folder. What is wrong with one cell is that cell's
    /// [`problem`](Run::problem).
    pub fn read(folder: &Path) -> Result<Campaign, CampaignError> {
        let path = folder.join(PLAN);
        let text = fs::read_to_string(&path).map_err(|source| CampaignError::File {
            path: path.clone(),
            source,
        })?;
        let plan =
            Plan::from_json(&text).map_err(|problem| CampaignError::Plan { path, problem })?;
        let runs = parallel::each(&plan.cells, |cell| run(folder, &plan, cell));
        Ok(Campaign {
            folder: folder.to_owned(),
            plan,
            runs,
        })
    }

    /// The cells that have not been run here.
    pub fn absent(&self) -> impl Iterator<Item = &Run> {
        self.runs
            .iter()
            .filter(|run| run.manifest.is_none() && run.problem.is_none())
    }

    /// Every file that is not what its manifest says: changed, cut short or gone.
    #[must_use]
    pub fn damage(&self) -> Vec<Damage> {
        let damage = |run: &Run| {
            let manifest = run.manifest.as_ref();
            manifest.map_or_else(Vec::new, |manifest| Damage::of(&run.folder, manifest))
        };
        parallel::each(&self.runs, damage).concat()
    }
}

/// A file that is not what its manifest says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

impl Damage {
    /// What is damaged in a cell's folder, of the files that its manifest names.
    #[must_use]
    pub fn of(folder: &Path, manifest: &Manifest) -> Vec<Damage> {
        let judge = |(name, asked): (&String, &FileFact)| {
            let path = folder.join(name);
            let problem = match File::open(&path).and_then(FileFact::of) {
                Ok(found) if found == *asked => return None,
                Ok(found) if found.bytes == asked.bytes => {
                    "its checksum is not the manifest's: a byte was changed".to_owned()
                }
                Ok(found) => format!(
                    "it has {} bytes, and the manifest says {}",
                    found.bytes, asked.bytes
                ),
                Err(problem) if problem.kind() == ErrorKind::NotFound => "it is gone".to_owned(),
                Err(problem) => problem.to_string(),
            };
            Some(Damage { path, problem })
        };
        manifest.files.iter().filter_map(judge).collect()
    }
}

fn run(campaign: &Path, plan: &Plan, cell: &Cell) -> Run {
    let folder = campaign.join(cell.folder());
    let (manifest, mut problem) = match manifest(&folder) {
        Ok(manifest) => (manifest, None),
        Err(problem) => (None, Some(problem)),
    };
    let verdict = manifest.as_ref().map(|manifest| manifest.verdict);
    let metrics = match verdict.is_some_and(has_rows) {
        true => Metrics::read(&folder, &CellFacts::from(cell))
            .map_err(|error| problem = Some(error.to_string()))
            .ok(),
        false => None,
    };
    let summary = Summary::new(cell, verdict, asked_ms(plan, cell), metrics.as_ref());
    Run {
        cell: cell.clone(),
        folder,
        manifest,
        metrics,
        summary,
        problem,
    }
}

fn manifest(folder: &Path) -> Result<Option<Manifest>, String> {
    let path = folder.join(Manifest::FILE);
    match fs::read_to_string(&path) {
        Ok(text) => Manifest::from_json(&text)
            .map(Some)
            .map_err(|problem| format!("{}: {problem}", path.display())),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
        Err(problem) => Err(format!("{}: {problem}", path.display())),
    }
}

/// The mean round trip that the cell's profile asks for; `None` on loopback, of which nothing is
/// asked.
fn asked_ms(plan: &Plan, cell: &Cell) -> Option<f64> {
    plan.profiles
        .get(&cell.topology)
        .and_then(|text| text.profile(&cell.topology).ok())
        .filter(|profile| !profile.is_loopback())
        .and_then(|profile| profile.asked())
        .map(|asked| asked.rtt_avg_ms)
}

/// Whether a run that ended so left its rows: one that did not come to its end may have none at all.
fn has_rows(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Complete | Verdict::Invalid)
}
