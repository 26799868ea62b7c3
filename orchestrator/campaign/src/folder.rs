//! A results folder that only this process writes to: the file that identifies it, and its lock.
//!
//! `campaign_folder` defines what a campaign keeps in it, `sweep_folder` what a sweep keeps in it beside the plan.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use plan::file_name::PLAN;
use record::file;
use record::folder::{self, Unwritable};
use record::lock::{self, NotLocked};

use crate::attach;
use crate::error::Error;
use crate::open_error::{FullError, LOCK, OpenError, RESULTS};

/// A folder with its lock.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    /// Never read. Closing the file releases the lock, however this process ends.
    _lock: File,
}

impl Folder {
    /// Opens a folder: a new one, or one that contains a plan.
    ///
    /// # Errors
    /// When it belongs to something else, is in use, or cannot be written.
    pub(crate) fn open(path: &Path) -> Result<Folder, OpenError> {
        fs::create_dir_all(path).map_err(|source| OpenError::NotWritable {
            path: path.to_owned(),
            remedy: remedy(),
            source,
        })?;
        // Checked before anything is written: a folder that belongs to something else stays as it was.
        if is_of_others(path)? {
            return Err(OpenError::Foreign(path.to_owned()));
        }
        let unlocked = |source| OpenError::NotLockable {
            path: path.to_owned(),
            remedy: remedy(),
            source,
        };
        let lock = file::open_or_create(&path.join(LOCK)).map_err(unlocked)?;
        lock::lock(&lock).map_err(|refused| match refused {
            NotLocked::InUse(holder) => OpenError::InUse {
                path: path.to_owned(),
                holder,
            },
            NotLocked::Unsupported(source) => OpenError::NoLocks {
                path: path.to_owned(),
                remedy: remedy(),
                source,
            },
            NotLocked::Other(source) => unlocked(source),
        })?;
        Ok(Folder {
            path: path.to_owned(),
            _lock: lock,
        })
    }

    /// Text of the identity file; `None` if the folder is new.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn identity(&self) -> Result<Option<String>, OpenError> {
        let path = self.identity_file();
        match file::text(&path, file::PLAN_BYTES) {
            Ok(text) => Ok(Some(text)),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
            Err(problem) => Err(OpenError::Unreadable { path, problem }),
        }
    }

    /// Writes the identity file.
    pub(crate) fn identify(&self, text: &str) -> Result<(), Unwritable> {
        folder::write_whole(&self.identity_file(), text.as_bytes())
    }

    /// Path of the identity file.
    pub(crate) fn identity_file(&self) -> PathBuf {
        self.path.join(PLAN)
    }

    /// Path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file that can be deleted and made again, and creates the folders in its path.
    pub(crate) fn leave(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        let below = Path::new(name).parent().unwrap_or(Path::new(""));
        let written = file::make_folder(&self.path, below)
            .and_then(|_| file::write(&self.path.join(name), content));
        Ok(written.map_err(|source| self.full(name, source))?)
    }

    /// The error for a file of this folder that can no longer be written.
    pub(crate) fn full(&self, name: &str, source: io::Error) -> FullError {
        FullError {
            path: self.path.join(name),
            source,
        }
    }
}

/// What to do about a folder that cannot be written. In webloop's containers it is a mount, and a
/// setting says which user writes there.
fn remedy() -> &'static str {
    if attach::is_contained() {
        "give RESULTS another folder, or OWNER somebody who may write there"
    } else {
        "choose another with --out"
    }
}

/// Whether the folder belongs to something else: it has no identity file, but more files than a run
/// leaves if it is killed just after its start.
fn is_of_others(path: &Path) -> Result<bool, OpenError> {
    let cannot = |source| OpenError::NotListed {
        path: path.to_owned(),
        source,
    };
    let partial = Path::new(PLAN).with_extension("partial");
    let mut others = false;
    for entry in fs::read_dir(path).map_err(cannot)? {
        let name = entry.map_err(cannot)?.file_name();
        if name == PLAN {
            return Ok(false);
        }
        others |= name != LOCK && name != partial.as_os_str();
    }
    Ok(others)
}

/// A new folder named after what it holds, the time and the seed: `results/smoke-20261121-041503-s1`.
#[must_use]
pub fn fresh(what: &str, seed: u64) -> PathBuf {
    named_now(what, &format!("-s{seed}"))
}

/// A new folder named after what it holds and the time: `results/bench-20261121-041503`.
#[must_use]
pub fn begun_now(what: &str) -> PathBuf {
    named_now(what, "")
}

/// A folder that nobody else has: it is made here. Of those that begin in the same second, each but the first has a
/// number behind its name.
fn named_now(what: &str, seed: &str) -> PathBuf {
    let now = jiff::Timestamp::now().strftime("%Y%m%d-%H%M%S");
    unused(Path::new(RESULTS), &format!("{what}-{now}{seed}"))
}

/// Makes a folder of this name in `place`, with a number behind it if there is one already.
fn unused(place: &Path, name: &str) -> PathBuf {
    let first = place.join(name);
    // Where it cannot be made, whoever opens it says why.
    if fs::create_dir_all(place).is_err() {
        return first;
    }
    let others = (2_u32..).map(|n| place.join(format!("{name}-{n}")));
    let mut paths = std::iter::once(first.clone()).chain(others);
    let is_free = |path: &PathBuf| match fs::create_dir(path) {
        Err(problem) => problem.kind() != ErrorKind::AlreadyExists,
        Ok(()) => true,
    };
    paths.find(is_free).unwrap_or(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_begin_in_one_second_have_names_of_their_own() {
        let place = tempfile::tempdir().expect("a folder");
        let names = || {
            let path = unused(&place.path().join("results"), "smoke-20261121-041503-s1");
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            assert!(path.is_dir());
            name.unwrap_or_default()
        };
        let first: Vec<String> = (0..3).map(|_| names()).collect();
        let base = "smoke-20261121-041503-s1";
        assert_eq!(
            first,
            [base.to_owned(), format!("{base}-2"), format!("{base}-3")]
        );
        // Also of many that begin at once.
        let all: Vec<String> = std::thread::scope(|scope| {
            let begun: Vec<_> = (0..8).map(|_| scope.spawn(names)).collect();
            begun
                .into_iter()
                .flat_map(std::thread::ScopedJoinHandle::join)
                .collect()
        });
        let distinct: std::collections::BTreeSet<&String> = all.iter().chain(&first).collect();
        assert_eq!(distinct.len(), 11);
    }
}
