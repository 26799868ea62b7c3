//! Results folders of one plan, merged into one: of each cell the best run that any of them has.
//!
//! What comes of it depends on the folders and not on their order. Cells come whole or not at all,
//! and what they take the place of is moved aside. Folders that a run has moved aside, and ones
//! that it has not finished, are not taken along.

use std::cmp::Reverse;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use analysis::campaign::PLAN;
use analysis::{Damage, Run};
use anyhow::{Context, anyhow};
use plan::{Cell, Manifest, Plan, Verdict};

use crate::exit::Failure;

/// A results folder to take cells from.
pub(crate) struct Source {
    folder: PathBuf,
    /// Its plan's text, byte by byte.
    text: String,
}

/// Folders that have one plan between them.
pub(crate) struct Sources {
    /// The plan.
    pub(crate) plan: Plan,
    /// Its text, as each of the folders has it.
    pub(crate) text: String,
    /// The folders.
    pub(crate) folders: Vec<PathBuf>,
}

/// What was done.
#[derive(Default)]
pub(crate) struct Merged {
    /// Cells that were copied.
    pub(crate) copied: usize,
    /// Cells that the merged folder had already, and nobody better.
    pub(crate) kept: usize,
    /// Files that are not what their manifests say, and manifests that are none.
    pub(crate) damage: Vec<Damage>,
}

impl Sources {
    /// The results folders that are `given`, and those that lie in them; and the one they are merged
    /// into, where there is one.
    ///
    /// # Errors
    /// Where one is no results folder, or two have different plans; exit code 2.
    pub(crate) fn find(given: &[PathBuf], out: &Path) -> Result<Sources, Failure> {
        let mut sources: Vec<Source> = Vec::new();
        for folder in given {
            let found = Source::of(folder).map_err(Failure::usage)?;
            if found.is_empty() {
                return Err(Failure::usage(anyhow!(
                    "{} is not a results folder and contains none: {PLAN} is missing",
                    folder.display()
                )));
            }
            sources.extend(found);
        }
        sources.extend(Source::read(out).map_err(Failure::usage)?);
        let (first, others) = sources
            .split_first()
            .ok_or_else(|| Failure::usage(anyhow!("there is no folder to collect from")))?;
        let plan = first.plan()?;
        if let Some(other) = others.iter().find(|other| other.text != first.text) {
            let difference = plan.difference(&other.plan()?);
            return Err(Failure::usage(anyhow!(
                "{} and {} have different plans: {}; collect folders of one plan only",
                first.folder.display(),
                other.folder.display(),
                difference.unwrap_or_else(|| "equal cells, written differently".to_owned())
            )));
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
    /// Where two folders have complete runs of a cell that are not the same, before anything is
    /// copied (exit code 2); where `out` cannot be written.
    pub(crate) fn merge_into(&self, out: &Path) -> Result<Merged, Failure> {
        let mut merged = Merged::default();
        let mut best: Vec<(&Cell, Candidate)> = Vec::new();
        for cell in &self.plan.cells {
            let mut candidates = self.candidates(cell, out, &mut merged.damage);
            no_conflict(&candidates).map_err(Failure::usage)?;
            candidates.retain_mut(|candidate| {
                let is_whole = candidate.damage.is_empty();
                merged.damage.append(&mut candidate.damage);
                is_whole
            });
            candidates.sort_by_key(Candidate::rank);
            best.extend(candidates.into_iter().next().map(|best| (cell, best)));
        }
        one_backend(&best).map_err(Failure::usage)?;
        for (cell, candidate) in best {
            match candidate.is_own {
                true => merged.kept += 1,
                false => {
                    let folder = cell.folder();
                    file::make_folder(out, folder.parent().unwrap_or(&folder))?;
                    candidate.copy_to(&out.join(folder))?;
                    merged.copied += 1;
                }
            }
        }
        Ok(merged)
    }

    /// The runs of a cell that there are, the merged folder's own first.
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
    /// A results folder, or those in a folder, by name.
    fn of(folder: &Path) -> anyhow::Result<Vec<Source>> {
        if let Some(source) = Source::read(folder)? {
            return Ok(vec![source]);
        }
        let entries = fs::read_dir(folder)
            .with_context(|| format!("cannot read the folder {}", folder.display()))?;
        let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        folders.retain(|folder| folder.is_dir());
        folders.sort();
        let sources = folders.iter().map(|folder| Source::read(folder));
        Ok(sources
            .collect::<anyhow::Result<Vec<_>>>()?
            .into_iter()
            .flatten()
            .collect())
    }

    /// A results folder; `None` of one without a plan.
    fn read(folder: &Path) -> anyhow::Result<Option<Source>> {
        let path = folder.join(PLAN);
        match file::text(&path, file::PLAN_BYTES) {
            Ok(text) => Ok(Some(Source {
                folder: folder.to_owned(),
                text,
            })),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
            Err(problem) => Err(anyhow!("cannot read {}: {problem}", path.display())),
        }
    }

    fn plan(&self) -> Result<Plan, Failure> {
        Plan::from_json(&self.text).map_err(|problem| {
            let path = self.folder.join(PLAN);
            Failure::usage(anyhow!("cannot use the plan {}: {problem}", path.display()))
        })
    }
}

/// The folders but for `out`, each once by whatever name.
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

/// A run of a cell, in one of the folders.
struct Candidate {
    folder: PathBuf,
    /// The manifest's text, byte by byte.
    text: String,
    manifest: Manifest,
    /// Why it is not taken.
    damage: Vec<Damage>,
    /// Whether it lies in the merged folder already.
    is_own: bool,
}

impl Candidate {
    /// A run; `None` where it has no manifest, which comes last.
    fn of(run: Run, is_own: bool) -> Result<Option<Candidate>, Vec<Damage>> {
        let Some(manifest) = run.manifest else {
            return match run.damage.is_empty() {
                true => Ok(None),
                false => Err(run.damage),
            };
        };
        let path = run.folder.join(Manifest::FILE);
        let text = file::text(&path, file::MANIFEST_BYTES).map_err(|problem| {
            let problem = problem.to_string();
            vec![Damage { path, problem }]
        })?;
        Ok(Some(Candidate {
            folder: run.folder,
            text,
            manifest,
            damage: run.damage,
            is_own,
        }))
    }

    fn is_complete(&self) -> bool {
        self.manifest.verdict == Verdict::Complete
    }

    /// The least is taken: complete before all, then what has most to look at, of equals the latest
    /// and, so that the order of the folders tells nothing, by its text; the merged folder's own
    /// before a copy of it.
    fn rank(&self) -> impl Ord + use<> {
        let kind = match self.manifest.verdict {
            Verdict::Complete => 0,
            Verdict::Disturbed => 1,
            Verdict::Invalid => 2,
            Verdict::Failed => 3,
            Verdict::Unsupported => 4,
        };
        let started = Reverse(self.manifest.started.clone());
        (kind, started, self.text.clone(), !self.is_own)
    }

    /// Copies what its manifest names, in a folder that gets its name when all is there and proved.
    fn copy_to(&self, target: &Path) -> anyhow::Result<()> {
        let cannot = || {
            format!(
                "cannot copy {} to {}; give the same command again",
                self.folder.display(),
                target.display()
            )
        };
        let mut partial = target.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        if fs::symlink_metadata(&partial).is_ok() {
            fs::remove_dir_all(&partial).with_context(cannot)?;
        }
        fs::create_dir(&partial).with_context(cannot)?;
        for (name, fact) in &self.manifest.files {
            copy(&self.folder.join(name), &partial.join(name), fact.bytes).with_context(cannot)?;
        }
        backend::write_whole(&partial.join(Manifest::FILE), self.text.as_bytes())
            .with_context(cannot)?;
        if let Some(damage) = Damage::of(&partial, &self.manifest).first() {
            return Err(anyhow!("{damage}")).with_context(cannot);
        }
        backend::move_aside(target).with_context(cannot)?;
        fs::rename(&partial, target).with_context(cannot)
    }
}

/// Copies a file of so many bytes, in whole or not at all.
fn copy(from: &Path, to: &Path, bytes: u64) -> io::Result<()> {
    let mut copy = OpenOptions::new().write(true).create_new(true).open(to)?;
    // What is longer is not what was looked at: its checksum tells.
    io::copy(&mut file::open(from)?.take(bytes), &mut copy)?;
    copy.sync_all()
}

/// Runs of two back-ends are two campaigns, whatever their plan.
fn one_backend(best: &[(&Cell, Candidate)]) -> anyhow::Result<()> {
    let Some(((_, first), others)) = best.split_first() else {
        return Ok(());
    };
    let backend = |candidate: &Candidate| candidate.manifest.backend.clone();
    match others
        .iter()
        .find(|(_, other)| backend(other) != backend(first))
    {
        None => Ok(()),
        Some((_, other)) => Err(anyhow!(
            "{} was run by {}, and {} by {}; collect folders of one back-end only. Nothing was copied",
            first.folder.display(),
            backend(first),
            other.folder.display(),
            backend(other)
        )),
    }
}

/// Two runs that both came to their end cannot both be the cell's.
fn no_conflict(candidates: &[Candidate]) -> anyhow::Result<()> {
    let mut complete = candidates.iter().filter(|one| one.is_complete());
    let Some(first) = complete.next() else {
        return Ok(());
    };
    match complete.find(|other| other.text != first.text) {
        None => Ok(()),
        Some(other) => Err(anyhow!(
            "{} and {} are complete runs of one cell, and not the same run; collect without one of \
             them, or move it away. Nothing was copied",
            first.folder.display(),
            other.folder.display()
        )),
    }
}
