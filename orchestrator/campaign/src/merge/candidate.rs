//! Candidates for the run of a cell in a merge: how they are ranked and copied.

use std::cmp::Reverse;
use std::fs::{self, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use analysis::Run;
use plan::{Cell, Verdict};
use record::{Damage, Manifest, file, folder};

use super::error::{Cause, MergeError};

/// A run of a cell, in one of the folders.
pub(super) struct Candidate {
    pub(super) folder: PathBuf,
    /// Text of the manifest, byte by byte.
    text: String,
    manifest: Manifest,
    /// Why it cannot be taken; empty if it can.
    pub(super) damage: Vec<Damage>,
    /// Whether it is in the merged folder already.
    pub(super) is_own: bool,
}

impl Candidate {
    /// Makes a candidate of a run; `None` if it has no manifest, which is the last file that a run
    /// writes.
    pub(super) fn of(run: Run, is_own: bool) -> Result<Option<Candidate>, Vec<Damage>> {
        let Some(manifest) = run.manifest else {
            return if run.damage.is_empty() {
                Ok(None)
            } else {
                Err(run.damage)
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

    /// Sort key; the smallest is taken. Complete runs come first, then the verdict with the most to
    /// look at, then the latest. Equal ones are ordered by text, so that the order of the folders
    /// does not matter, and the merged folder's own run comes before a copy of it.
    pub(super) fn rank(&self) -> impl Ord + use<> {
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

    /// Copies the files that its manifest names. The folder gets its final name once all are there
    /// and checked.
    pub(super) fn copy_to(&self, target: &Path) -> Result<(), Cause> {
        let mut partial = target.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        if fs::symlink_metadata(&partial).is_ok() {
            fs::remove_dir_all(&partial)?;
        }
        fs::create_dir(&partial)?;
        for (name, fact) in &self.manifest.files {
            copy(&self.folder.join(name), &partial.join(name), fact.bytes)?;
        }
        folder::write_whole(&partial.join(Manifest::FILE), self.text.as_bytes())?;
        if let Some(damage) = Damage::of(&partial, &self.manifest).into_iter().next() {
            return Err(damage.into());
        }
        folder::move_aside(target)?;
        Ok(fs::rename(&partial, target)?)
    }
}

/// Copies at most `bytes` bytes of a file into a new one, and syncs it to disk.
fn copy(from: &Path, to: &Path, bytes: u64) -> io::Result<()> {
    let mut copy = OpenOptions::new().write(true).create_new(true).open(to)?;
    // Copy no more than was checked. If the content has changed since, its checksum tells.
    io::copy(&mut file::open(from)?.take(bytes), &mut copy)?;
    copy.sync_all()
}

/// Checks that all runs have one back-end: runs of two back-ends are two campaigns, whatever their
/// plan.
pub(super) fn check_backend(best: &[(&Cell, Candidate)]) -> Result<(), MergeError> {
    let Some(((_, first), others)) = best.split_first() else {
        return Ok(());
    };
    let backend = |candidate: &Candidate| candidate.manifest.backend.clone();
    match others
        .iter()
        .find(|(_, other)| backend(other) != backend(first))
    {
        None => Ok(()),
        Some((_, other)) => Err(MergeError::OtherBackend {
            first: first.folder.clone(),
            first_backend: backend(first),
            other: other.folder.clone(),
            other_backend: backend(other),
        }),
    }
}

/// Checks that the complete runs of a cell do not differ.
pub(super) fn check_conflict(candidates: &[Candidate]) -> Result<(), MergeError> {
    let mut complete = candidates.iter().filter(|one| one.is_complete());
    let Some(first) = complete.next() else {
        return Ok(());
    };
    match complete.find(|other| other.text != first.text) {
        None => Ok(()),
        Some(other) => Err(MergeError::Conflict {
            first: first.folder.clone(),
            other: other.folder.clone(),
        }),
    }
}
