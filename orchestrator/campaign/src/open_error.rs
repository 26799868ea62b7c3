//! Why a results folder is not opened for what is asked, or cannot be written any more.

use std::io;
use std::path::PathBuf;

use backend::RunError;

/// Where results go when no folder is given.
pub const RESULTS: &str = "results";

/// The file whose lock says that a folder is in use.
pub(crate) const LOCK: &str = ".lock";

/// Why a folder is not opened for what is asked.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be made, or be written to.
    #[error("cannot write the results folder {}; {remedy}", path.display())]
    NotWritable {
        /// The folder.
        path: PathBuf,
        /// What to do.
        remedy: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// Its lock cannot be had.
    #[error(
        "cannot write the results folder {}; {remedy}: cannot lock {}",
        path.display(), path.join(LOCK).display()
    )]
    NotLockable {
        /// The folder.
        path: PathBuf,
        /// What to do.
        remedy: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// It is of something else.
    #[error(
        "{} has files in it and no {identity}; give --out a new or empty folder", path.display()
    )]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// The file that would say what it is of.
        identity: &'static str,
    },
    /// Another process writes to it.
    #[error("{} is in use by another run; choose another folder with --out", .0.display())]
    InUse(PathBuf),
    /// Its names cannot be read.
    #[error("cannot read {}", path.display())]
    NotListed {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file in it cannot be read.
    #[error("cannot read {}: {problem}; choose another folder with --out", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        problem: io::Error,
    },
    /// It has another plan.
    #[error(
        "{} holds the results of another plan; choose another folder with --out", .0.display()
    )]
    OtherPlan(PathBuf),
    /// None has this plan.
    #[error(
        "no folder in {RESULTS}/ has this plan, so there is nothing to continue; to begin, omit \
         --resume and --failed, or name a folder with --out"
    )]
    NoneBegun,
    /// It has another sweep.
    #[error(
        "{} holds the results of another sweep: its {key} is {other}, and this one's is {own}; \
         choose another folder with --out", path.display()
    )]
    OtherSweep {
        /// The folder.
        path: PathBuf,
        /// In what the two differ.
        key: String,
        /// What the folder has.
        other: String,
        /// What is asked for.
        own: String,
    },
    /// What says which sweep it is of is damaged.
    #[error("{} is damaged: {problem}; choose another folder with --out", path.display())]
    Damaged {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        problem: serde_json::Error,
    },
    /// A row of its sweep is damaged.
    #[error(
        "{}:{line}: {problem}; delete the line to repeat its run", path.display()
    )]
    DamagedRow {
        /// The file of rows.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// A file that holds nothing cannot be removed.
    #[error("cannot write {}", path.display())]
    NotRemoved {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A folder in it is none.
    #[error(transparent)]
    NoFolder(io::Error),
    /// What it is of cannot be written down.
    #[error(transparent)]
    Write(#[from] RunError),
    /// There is no room for what will come.
    #[error(transparent)]
    Full(#[from] FullError),
}

/// A file of a folder cannot be written any more.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}; free space and run the same command again", path.display())]
pub struct FullError {
    pub(crate) path: PathBuf,
    pub(crate) source: io::Error,
}
