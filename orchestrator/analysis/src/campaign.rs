//! A results folder as one value: its plan, and the manifest and metrics of each cell.
//!
//! The folder may be a copy, a merge or a part of a campaign. A damaged cell has no metrics; the
//! others are still read. Nothing is written.

mod cell;
mod reading;

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use plan::{Cell, Plan, Verdict, file_name};
use record::{Damage, Manifest, file};
use thiserror::Error;

use crate::metrics::Metrics;
use crate::parallel;
use crate::recovery::Recovery;
use crate::summary::Summary;

use self::reading::Reading;

pub use self::reading::Fresh;

/// Why a folder cannot be read as a results folder.
#[derive(Debug, Error)]
pub enum CampaignError {
    /// The plan is missing or cannot be read.
    #[error("{path}: {source}; a results folder has a plan.json")]
    File {
        /// The plan's file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file is not a valid plan.
    #[error("{path}: {problem}")]
    Plan {
        /// The plan's file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// It has a sweep's points, and no cells.
    #[error(
        "{} is of a sweep, which has no cells: its points are in points.csv, and its maps in report.html", .0.display()
    )]
    Sweep(PathBuf),
}

/// The contents of a results folder.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// The folder.
    pub folder: PathBuf,
    /// The plan of the runs.
    pub plan: Plan,
    /// Every cell of the plan, in plan order, whether it was run or not.
    pub runs: Vec<Run>,
}

/// One cell of a campaign.
#[derive(Debug, Clone)]
pub struct Run {
    /// The cell.
    pub cell: Cell,
    /// Its folder, which does not exist if the cell has not been run.
    pub folder: PathBuf,
    /// The run's manifest; `None` if the cell has not been run or the manifest cannot be read.
    pub manifest: Option<Manifest>,
    /// Metrics from its rows; `None` if there are none or the folder is damaged.
    pub metrics: Option<Metrics>,
    /// How it came through its fault; `None` without one, or without metrics.
    pub recovery: Option<Recovery>,
    /// The cell as one row of `summary.csv`.
    pub summary: Summary,
    /// Every file that is not as the manifest or the plan requires; empty if the folder is whole.
    pub damage: Vec<Damage>,
}

impl Run {
    /// Whether it ran to its end over a link that held, and its folder is whole. Figures and claims
    /// are based on such runs.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.verdict() == Some(Verdict::Complete) && self.metrics.is_some()
    }

    /// Gives it the verdict of a later judgement, with its reasons.
    pub fn judged_again(&mut self, verdict: Verdict, reasons: Vec<String>) {
        if let Some(manifest) = &mut self.manifest {
            manifest.verdict = verdict;
            manifest.reasons = reasons;
            self.summary.verdict = Some(verdict);
        }
    }

    /// Its first deadline, ns; 0 if nothing says when that was.
    #[must_use]
    pub fn start_ns(&self) -> u64 {
        let manifest = self.manifest.as_ref();
        manifest.map_or(0, |manifest| manifest.start_ns)
    }

    /// From its first deadline to its planned end, ns.
    #[must_use]
    pub fn lasts_ns(&self) -> Range<u64> {
        let start_ns = self.start_ns();
        start_ns..start_ns.saturating_add(self.cell.duration_ns)
    }

    /// How it ended; `None` if there is no manifest.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.manifest.as_ref().map(|manifest| manifest.verdict)
    }
}

impl Campaign {
    /// Reads a results folder and checks every file against its manifest.
    ///
    /// # Errors
    /// [`CampaignError`] if it is not a results folder. A fault of a single cell is in that cell's
    /// [`damage`](Run::damage).
    pub fn read(folder: &Path) -> Result<Campaign, CampaignError> {
        Campaign::read_after(folder, &Fresh::new())
    }

    /// As [`read`](Campaign::read), after a part of its cells was run by this process: their rows are not read again.
    ///
    /// # Errors
    /// As for [`read`](Campaign::read).
    pub fn read_after(folder: &Path, fresh: &Fresh) -> Result<Campaign, CampaignError> {
        let plan = Campaign::plan(folder)?;
        let reading = Reading::new(folder, &plan, fresh);
        let runs = parallel::each(&plan.cells, |cell| reading.run(cell));
        drop(reading);
        Ok(Campaign {
            folder: folder.to_owned(),
            plan,
            runs,
        })
    }

    /// Reads the plan of a results folder.
    ///
    /// # Errors
    /// [`CampaignError`] if there is none.
    pub fn plan(folder: &Path) -> Result<Plan, CampaignError> {
        let path = folder.join(file_name::PLAN);
        let text = file::text(&path, file::PLAN_BYTES).map_err(|source| CampaignError::File {
            path: path.clone(),
            source,
        })?;
        let plan = Plan::from_json(&text).map_err(|problem| CampaignError::Plan {
            path,
            problem: problem.to_string(),
        })?;
        match plan.sweep {
            None => Ok(plan),
            Some(_) => Err(CampaignError::Sweep(folder.to_owned())),
        }
    }

    /// Reads every run of a plan in a folder and keeps of each only what `of` makes of it, in the order of the plan.
    pub fn each_run<R: Send>(folder: &Path, plan: &Plan, of: impl Fn(Run) -> R + Sync) -> Vec<R> {
        let none = Fresh::new();
        let reading = Reading::new(folder, plan, &none);
        parallel::each(&plan.cells, |cell| of(reading.run(cell)))
    }

    /// As [`each_run`](Campaign::each_run), for a plan of a hundred thousand: what is kept lies together.
    pub fn each_row<R: Send + Clone>(
        folder: &Path,
        plan: &Plan,
        of: impl Fn(Run) -> R + Sync,
    ) -> Vec<R> {
        let none = Fresh::new();
        let reading = Reading::new(folder, plan, &none);
        parallel::each_apart(&plan.cells, |cell| of(reading.run(cell)))
    }

    /// The cells that have not been run in this folder.
    pub fn absent(&self) -> impl Iterator<Item = &Run> {
        self.runs
            .iter()
            .filter(|run| run.manifest.is_none() && run.damage.is_empty())
    }

    /// Every damaged file: changed, truncated, missing, or from another run.
    #[must_use]
    pub fn damage(&self) -> Vec<Damage> {
        let damage = self.runs.iter().flat_map(|run| &run.damage);
        damage.cloned().collect()
    }

    /// Whether any run was in virtual time.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        let mut runs = self.runs.iter();
        runs.any(|run| run.summary.is_simulated())
    }
}
