//! Merges results folders of one plan into one, with the best run of each cell that any of them has.
//!
//! The result depends on the folders and not on their order. Cells are copied whole or not at all,
//! and what they replace is moved aside. Folders that a run has moved aside or not finished are not
//! copied.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use analysis::Run;
use plan::file_name::PLAN;
use plan::{Cell, Plan};

use crate::error::Error;

use candidate::{Candidate, check_backend, check_conflict};
pub use error::MergeError;
use record::{Damage, file};

mod candidate;
mod error;

/// A results folder to take cells from.
struct Source {
    folder: PathBuf,
    /// Text of its plan, byte by byte.
    text: String,
}

/// Folders that share one plan.
#[derive(Debug)]
pub struct Sources {
    /// The plan.
    pub plan: Plan,
    /// Its text, the same in each folder.
    pub text: String,
    /// The folders.
    pub folders: Vec<PathBuf>,
}

/// Result of a merge.
#[derive(Debug, Default)]
pub struct Merged {
    /// Cells that were copied.
    pub copied: usize,
    /// Cells for which the merged folder already had the best run.
    pub kept: usize,
    /// Files that do not match their manifests, and invalid manifests.
    pub damage: Vec<Damage>,
}

impl Sources {
    /// Finds the results folders: those in `given`, or else the ones directly inside them. If `out`
    /// is a results folder already, it has to have the same plan.
    ///
    /// # Errors
    /// When a folder is not a results folder and contains none, or two have different plans.
    pub fn find(given: &[PathBuf], out: &Path) -> Result<Sources, Error> {
        let mut sources: Vec<Source> = Vec::new();
        for folder in given {
            let found = Source::of(folder)?;
            if found.is_empty() {
                return Err(MergeError::NoPlan(folder.clone()).into());
            }
            sources.extend(found);
        }
        sources.extend(Source::read(out)?);
        let (first, others) = sources.split_first().ok_or(MergeError::Nothing)?;
        let plan = first.plan()?;
        if let Some(other) = others.iter().find(|other| other.text != first.text) {
            let difference = plan.difference(&other.plan()?);
            let problem = MergeError::OtherPlan {
                first: first.folder.clone(),
                other: other.folder.clone(),
                difference: difference
                    .unwrap_or_else(|| "equal cells, written differently".to_owned()),
            };
            return Err(problem.into());
        }
        Ok(Sources {
            plan,
            text: first.text.clone(),
            folders: distinct(&sources, out),
        })
    }

    /// Merges all cells into `out`, which has the plan already.
    ///
    /// # Errors
    /// When complete runs of a cell differ, or runs have different back-ends; nothing is copied
    /// then. When `out` cannot be written.
    pub fn merge_into(&self, out: &Path) -> Result<Merged, Error> {
        let mut merged = Merged::default();
        let mut best: Vec<(&Cell, Candidate)> = Vec::new();
        for cell in &self.plan.cells {
            let mut candidates = self.candidates(cell, out, &mut merged.damage);
            check_conflict(&candidates)?;
            candidates.retain_mut(|candidate| {
                let is_whole = candidate.damage.is_empty();
                merged.damage.append(&mut candidate.damage);
                is_whole
            });
            candidates.sort_by_key(Candidate::rank);
            best.extend(candidates.into_iter().next().map(|best| (cell, best)));
        }
        check_backend(&best)?;
        for (cell, candidate) in best {
            if candidate.is_own {
                merged.kept += 1;
            } else {
                let folder = cell.folder();
                file::make_folder(out, folder.parent().unwrap_or(&folder))?;
                let to = out.join(folder);
                candidate
                    .copy_to(&to)
                    .map_err(|source| MergeError::NotCopied {
                        from: candidate.folder.clone(),
                        to,
                        source,
                    })?;
                merged.copied += 1;
            }
        }
        Ok(merged)
    }

    /// The runs of a cell in all folders, the merged folder's own first.
    fn candidates(&self, cell: &Cell, out: &Path, damage: &mut Vec<Damage>) -> Vec<Candidate> {
        let own = std::iter::once((out, true));
        let others = self.folders.iter().map(|folder| (folder.as_path(), false));
        own.chain(others)
            .filter_map(|(campaign, is_own)| {
                let run = Run::read(campaign, &self.plan, cell);
                Candidate::of(run, is_own).unwrap_or_else(|problems| {
                    damage.extend(problems);
                    None
                })
            })
            .collect()
    }
}

impl Source {
    /// Reads a results folder, or else those directly inside it, sorted by name.
    fn of(folder: &Path) -> Result<Vec<Source>, MergeError> {
        if let Some(source) = Source::read(folder)? {
            return Ok(vec![source]);
        }
        let entries = fs::read_dir(folder).map_err(|source| MergeError::NotListed {
            path: folder.to_owned(),
            source,
        })?;
        let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        folders.retain(|folder| folder.is_dir());
        folders.sort();
        let sources = folders.iter().map(|folder| Source::read(folder));
        Ok(sources
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .flatten()
            .collect())
    }

    /// Reads a results folder; `None` if it has no plan.
    fn read(folder: &Path) -> Result<Option<Source>, MergeError> {
        let path = folder.join(PLAN);
        match file::text(&path, file::PLAN_BYTES) {
            Ok(text) => Ok(Some(Source {
                folder: folder.to_owned(),
                text,
            })),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
            Err(problem) => Err(MergeError::Unreadable { path, problem }),
        }
    }

    fn plan(&self) -> Result<Plan, MergeError> {
        Plan::from_json(&self.text).map_err(|problem| MergeError::BadPlan {
            path: self.folder.join(PLAN),
            problem: problem.to_string(),
        })
    }
}

/// The folders without `out`, each once even if it was given by several names.
fn distinct(sources: &[Source], out: &Path) -> Vec<PathBuf> {
    let real = |folder: &Path| fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let mut known = vec![real(out)];
    let mut folders = Vec::new();
    for Source { folder, .. } in sources {
        let name = real(folder);
        if !known.contains(&name) {
            known.push(name);
            folders.push(folder.clone());
        }
    }
    folders
}
