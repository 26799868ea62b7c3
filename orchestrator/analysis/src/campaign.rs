//! Reads a results folder: its plan, and the manifest and metrics of each cell.
//!
//! The folder may be a copy, a merge or a part of a campaign. A damaged cell has no metrics; the
//! others are still read. Nothing is written.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use link::Profile;
use manifest::Manifest;
use plan::{Cell, Plan, ProfileText, Verdict, file_name};
use thiserror::Error;

use crate::metrics::{CellFacts, Metrics};
use crate::parallel;
use crate::recovery::{Recovery, read_recovery};
use crate::summary::{LinkFacts, Summary};
use crate::whole::{self, Damage, ROWS, Vouched};

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
        let path = folder.join(file_name::PLAN);
        let text = file::text(&path, file::PLAN_BYTES).map_err(|source| CampaignError::File {
            path: path.clone(),
            source,
        })?;
        let plan =
            Plan::from_json(&text).map_err(|problem| CampaignError::Plan { path, problem })?;
        let links = Links::of(&plan);
        let manifests = parallel::each(&plan.cells, |cell| manifest(folder, cell));
        let mut known = manifests.iter().filter_map(|of| of.as_ref().ok()?.as_ref());
        let backend = known.next().map(|first| first.backend.as_str());
        let cells: Vec<_> = plan.cells.iter().zip(&manifests).collect();
        let runs = parallel::each(&cells, |(cell, manifest)| {
            let is_loopback = links.is_loopback(cell);
            let facts = links.facts(cell);
            Run::of(folder, &plan, cell, manifest, backend, is_loopback, facts)
        });
        Ok(Campaign {
            folder: folder.to_owned(),
            plan,
            runs,
        })
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

impl Run {
    /// Reads the run of one cell in a campaign's folder, if there is one. Its summary has no link
    /// facts: the profile is not played over a long time for one cell alone.
    #[must_use]
    pub fn read(campaign: &Path, plan: &Plan, cell: &Cell) -> Run {
        let manifest = manifest(campaign, cell);
        let is_loopback = plan.is_loopback(&cell.topology);
        let facts = LinkFacts::default();
        Run::of(campaign, plan, cell, &manifest, None, is_loopback, facts)
    }

    /// As [`read`](Run::read), with a manifest that has already been read. `backend` is the back-end
    /// of the folder's first run that has a manifest.
    fn of(
        campaign: &Path,
        plan: &Plan,
        cell: &Cell,
        manifest: &Result<Option<Manifest>, Damage>,
        backend: Option<&str>,
        is_loopback: bool,
        link: LinkFacts,
    ) -> Run {
        let folder = campaign.join(cell.folder());
        let (manifest, mut damage) = match manifest {
            Ok(manifest) => (manifest.clone(), Vec::new()),
            Err(damage) => (None, vec![damage.clone()]),
        };
        let mut metrics = None;
        if let Some(manifest) = &manifest {
            let mut faults = whole::faults(manifest, plan, cell, is_loopback);
            if let Some(other) = backend.filter(|other| *other != manifest.backend) {
                faults.push(format!(
                    "it was run by {}, and the folder's first run by {other}; a campaign has one \
                     back-end",
                    manifest.backend
                ));
            }
            let path = folder.join(Manifest::FILE);
            damage.extend(faults.into_iter().map(|problem| Damage {
                path: path.clone(),
                problem,
            }));
            let read = read(&folder, cell, manifest);
            metrics = read.map_err(|found| damage.extend(found)).ok().flatten();
        }
        // If one file of a cell is damaged, none of its rows is trusted.
        let metrics = metrics.filter(|_| damage.is_empty());
        let started = manifest.as_ref().filter(|_| metrics.is_some());
        let recovery = started.and_then(|manifest| {
            let spells = plan.fault_spells(cell);
            // The ticks were read whole a moment ago.
            read_recovery(&folder, cell, &spells, manifest.start_ns).ok()?
        });
        let summary = Summary::new(cell, manifest.as_ref(), link, metrics.as_ref());
        let summary = summary.after_fault(cell, recovery.as_ref());
        Run {
            cell: cell.clone(),
            folder,
            manifest,
            metrics,
            recovery,
            summary,
            damage,
        }
    }
}

/// The profiles of a plan, each played once over a long time for its link facts.
struct Links(BTreeMap<String, (Profile, LinkFacts)>);

impl Links {
    fn of(plan: &Plan) -> Links {
        let profiles: Vec<(&String, &ProfileText)> = plan.profiles.iter().collect();
        let links = parallel::each(&profiles, |(name, text)| {
            let profile = text.profile(name).ok()?;
            let facts = LinkFacts::of(&profile);
            Some(((*name).clone(), (profile, facts)))
        });
        Links(links.into_iter().flatten().collect())
    }

    fn is_loopback(&self, cell: &Cell) -> bool {
        let link = self.0.get(&cell.topology);
        link.is_some_and(|(profile, _)| profile.is_loopback())
    }

    fn facts(&self, cell: &Cell) -> LinkFacts {
        let link = self.0.get(&cell.topology);
        link.map_or_else(LinkFacts::default, |(profile, facts)| {
            facts.in_run(profile, cell)
        })
    }
}

/// The metrics of a run that left rows. Checks each file against the manifest while reading.
fn read(folder: &Path, cell: &Cell, manifest: &Manifest) -> Result<Option<Metrics>, Vec<Damage>> {
    let has_rows = whole::has_rows(manifest.verdict);
    let is_read = |name: &str| has_rows && (ROWS.contains(&name) || name == file_name::SECOND);
    let mut damage = Damage::among(folder, manifest, |name| !is_read(name));
    if has_rows && ROWS.iter().all(|name| manifest.files.contains_key(*name)) {
        let read = Vouched::of(folder, manifest).and_then(|vouched| {
            Metrics::read_whole(folder, &CellFacts::from(cell), &vouched)
                .map_err(|faults| faults.into_iter().map(Damage::from).collect())
        });
        match read {
            Ok(metrics) if damage.is_empty() => return Ok(Some(metrics)),
            Ok(_) => {}
            Err(found) => damage.extend(found),
        }
    }
    if damage.is_empty() {
        Ok(None)
    } else {
        Err(damage)
    }
}

/// The manifest in a cell's folder, if there is one.
fn manifest(campaign: &Path, cell: &Cell) -> Result<Option<Manifest>, Damage> {
    let folder = campaign.join(cell.folder());
    for path in [folder.parent().unwrap_or(&folder), &folder] {
        file::check_folder(path).map_err(|problem| Damage {
            path: path.to_owned(),
            problem: problem.to_string(),
        })?;
    }
    let path = folder.join(Manifest::FILE);
    let damage = |problem| Damage {
        path: path.clone(),
        problem,
    };
    match file::text(&path, file::MANIFEST_BYTES) {
        Ok(text) => Manifest::from_json(&text).map(Some).map_err(damage),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
        Err(problem) => Err(damage(problem.to_string())),
    }
}
