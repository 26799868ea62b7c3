//! A campaign's results folder: its plan, its lock, and the cells in it.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use plan::Plan;
use rustix::fs::{FlockOperation, flock};

use crate::attach;
use crate::exit::Failure;

/// Where results go when no folder is given.
const RESULTS: &str = "results";

/// The file whose lock says that a folder is in use.
const LOCK: &str = ".lock";

/// The file that says what a folder is for.
const PLAN: &str = "plan.json";

/// A results folder that this process, and no other, writes to.
pub(crate) struct Campaign {
    folder: PathBuf,
    /// Held, not read: the lock goes when the file is closed, however this process ends.
    _lock: File,
}

impl Campaign {
    /// Opens the folder for a plan: a new one, or one with the same plan to be continued.
    ///
    /// # Errors
    /// When it belongs to another plan, is in use, or cannot be written; exit code 2.
    pub(crate) fn open(plan: &Plan, asked: Option<&Path>) -> Result<Campaign, Failure> {
        let folder = asked.map_or_else(|| fresh(plan), Path::to_path_buf);
        Campaign::open_text(&plan.to_json(), &folder)
    }

    /// Opens a folder for the plan of this text, byte by byte.
    ///
    /// # Errors
    /// As [`open`](Campaign::open).
    pub(crate) fn open_text(plan: &str, folder: &Path) -> Result<Campaign, Failure> {
        let cannot = || {
            format!(
                "cannot write the results folder {}; {}",
                folder.display(),
                remedy()
            )
        };
        fs::create_dir_all(folder)
            .with_context(cannot)
            .map_err(Failure::usage)?;
        let file = folder.join(PLAN);
        // Asked first of all: a folder of somebody else's is left as it was.
        if is_of_others(folder).map_err(Failure::usage)? {
            return Err(Failure::usage(anyhow!(
                "{} has files in it and no plan.json; give --out a new or empty folder",
                folder.display()
            )));
        }
        let lock = File::create(folder.join(LOCK))
            .with_context(cannot)
            .map_err(Failure::usage)?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive).map_err(|_| {
            Failure::usage(anyhow!(
                "{} is in use by another run; choose another folder with --out",
                folder.display()
            ))
        })?;
        match fs::read_to_string(&file) {
            Ok(text) if text == plan => {}
            Ok(_) => {
                return Err(Failure::usage(anyhow!(
                    "{} holds the results of another plan; choose another folder with --out",
                    folder.display()
                )));
            }
            Err(problem) if problem.kind() == ErrorKind::NotFound => {
                backend::write_whole(&file, plan.as_bytes()).map_err(Failure::usage)?;
            }
            Err(problem) => {
                return Err(Failure::usage(anyhow!(
                    "cannot read {}: {problem}; choose another folder with --out",
                    file.display()
                )));
            }
        }
        Ok(Campaign {
            folder: folder.to_owned(),
            _lock: lock,
        })
    }

    /// The newest folder that was begun for this plan and got its name from the time.
    ///
    /// # Errors
    /// When there is none; exit code 2.
    pub(crate) fn latest(plan: &Plan) -> Result<PathBuf, Failure> {
        let start = format!("{}-", plan.experiment);
        let text = plan.to_json();
        let mut folders: Vec<PathBuf> = fs::read_dir(RESULTS)
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&start))
            .map(|entry| entry.path())
            .filter(|folder| fs::read_to_string(folder.join(PLAN)).is_ok_and(|own| own == text))
            .collect();
        // The names end with the time.
        folders.sort();
        folders.pop().ok_or_else(|| {
            Failure::usage(anyhow!(
                "no folder in {RESULTS}/ has this plan, so there is nothing to continue; \
                 leave --resume and --failed out to begin, or name a folder with --out"
            ))
        })
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its plan's file.
    pub(crate) fn plan_file(&self) -> PathBuf {
        self.folder.join(PLAN)
    }

    /// Leaves a derived file, which can be deleted and made again.
    pub(crate) fn leave(&self, name: &str, content: &[u8]) -> anyhow::Result<()> {
        let path = self.folder.join(name);
        File::create(&path)
            .and_then(|mut file| file.write_all(content))
            .with_context(|| {
                format!(
                    "cannot write {}; free space and give the same command again",
                    path.display()
                )
            })
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

/// Whether there is no plan in it, but more than a run leaves that is killed in its first moment.
fn is_of_others(folder: &Path) -> anyhow::Result<bool> {
    let names: Vec<_> = fs::read_dir(folder)
        .with_context(|| format!("cannot read {}", folder.display()))?
        .flatten()
        .map(|entry| entry.file_name())
        .collect();
    let first_moment = |name: &OsString| name == LOCK || name == "plan.partial";
    Ok(!names.iter().any(|name| name == PLAN) && !names.iter().all(first_moment))
}

/// A folder that tells when, what and which seed: `results/smoke-20261121-041503-s1`.
pub(crate) fn fresh(plan: &Plan) -> PathBuf {
    let now = jiff::Timestamp::now().strftime("%Y%m%d-%H%M%S");
    Path::new(RESULTS).join(format!("{}-{now}-s{}", plan.experiment, plan.seed))
}
