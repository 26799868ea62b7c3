//! A results folder that this process, and no other, writes to: what tells whose it is, and its lock.
//!
//! What a campaign has in it is in `campaign`, what a sweep has in `sweep_folder`.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use rustix::fs::{FlockOperation, flock};

use crate::attach;

/// Where results go when no folder is given.
pub(crate) const RESULTS: &str = "results";

/// The file whose lock says that a folder is in use.
const LOCK: &str = ".lock";

/// A folder with its lock.
pub(crate) struct Folder {
    path: PathBuf,
    /// The file that says what the folder is of.
    identity: &'static str,
    /// Held, not read: the lock goes when the file is closed, however this process ends.
    _lock: File,
}

impl Folder {
    /// Opens a folder: a new one, or one that has a file of this name.
    ///
    /// # Errors
    /// When it belongs to something else, is in use, or cannot be written.
    pub(crate) fn open(path: &Path, identity: &'static str) -> anyhow::Result<Folder> {
        let named = path.display();
        let cannot = || format!("cannot write the results folder {named}; {}", remedy());
        fs::create_dir_all(path).with_context(cannot)?;
        // Asked first of all: a folder of somebody else's is left as it was.
        if is_of_others(path, identity)? {
            return Err(anyhow!(
                "{named} has files in it and no {identity}; give --out a new or empty folder"
            ));
        }
        let lock = path.join(LOCK);
        let lock = file::open_or_create(&lock)
            .with_context(|| format!("cannot lock {}", lock.display()))
            .with_context(cannot)?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive).map_err(|_| {
            anyhow!("{named} is in use by another run; choose another folder with --out")
        })?;
        Ok(Folder {
            path: path.to_owned(),
            identity,
            _lock: lock,
        })
    }

    /// What the folder says that it is of; none where it is new.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn identity(&self) -> anyhow::Result<Option<String>> {
        let file = self.identity_file();
        match file::text(&file, file::PLAN_BYTES) {
            Ok(text) => Ok(Some(text)),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(None),
            Err(problem) => Err(anyhow!(
                "cannot read {}: {problem}; choose another folder with --out",
                file.display()
            )),
        }
    }

    /// Says what the folder is of.
    pub(crate) fn identify(&self, text: &str) -> anyhow::Result<()> {
        Ok(backend::write_whole(
            &self.identity_file(),
            text.as_bytes(),
        )?)
    }

    /// The file that says what the folder is of.
    pub(crate) fn identity_file(&self) -> PathBuf {
        self.path.join(self.identity)
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Leaves a file that can be deleted and made again; its folders are made.
    pub(crate) fn leave(&self, name: &str, content: &[u8]) -> anyhow::Result<()> {
        let below = Path::new(name).parent().unwrap_or(Path::new(""));
        file::make_folder(&self.path, below)
            .and_then(|_| file::write(&self.path.join(name), content))
            .with_context(|| self.full(name))
    }

    /// What to do where a file of it cannot be written any more.
    pub(crate) fn full(&self, name: &str) -> String {
        format!(
            "cannot write {}; free space and give the same command again",
            self.path.join(name).display()
        )
    }
}

/// What to do about a folder that cannot be written. In webloop's containers it is a mount, and
/// who writes there is a setting.
fn remedy() -> &'static str {
    if attach::is_contained() {
        "give RESULTS another folder, or OWNER somebody who may write there"
    } else {
        "choose another with --out"
    }
}

/// Whether nothing in it says what it is of, but there is more than a run leaves that is killed in
/// its first moment.
fn is_of_others(path: &Path, identity: &str) -> anyhow::Result<bool> {
    let cannot = || format!("cannot read {}", path.display());
    let partial = Path::new(identity).with_extension("partial");
    let mut others = false;
    for entry in fs::read_dir(path).with_context(cannot)? {
        let name = entry.with_context(cannot)?.file_name();
        if name == identity {
            return Ok(false);
        }
        others |= name != LOCK && name != partial.as_os_str();
    }
    Ok(others)
}

/// A folder that tells when, what and which seed: `results/smoke-20261121-041503-s1`.
pub(crate) fn fresh(what: &str, seed: u64) -> PathBuf {
    let now = jiff::Timestamp::now().strftime("%Y%m%d-%H%M%S");
    Path::new(RESULTS).join(format!("{what}-{now}-s{seed}"))
}
