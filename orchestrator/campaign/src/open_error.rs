//! Why a results folder cannot be opened for a use, or can no longer be written.

use std::io;
use std::path::PathBuf;

use plan::file_name::PLAN;
use record::folder::Unwritable;
use record::lock::Holder;

/// Where results go when no folder is given.
pub const RESULTS: &str = "results";

/// The file whose lock says that a folder is in use.
pub(crate) const LOCK: &str = ".lock";

/// Why a folder cannot be opened for a use.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be created or written to.
    #[error("cannot write the results folder {}; {remedy}", path.display())]
    NotWritable {
        /// The folder.
        path: PathBuf,
        /// What to do.
        remedy: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// Its lock file cannot be opened.
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
    /// It belongs to something else.
    #[error("{} has files in it and no {PLAN}; give --out a new or empty folder", .0.display())]
    Foreign(PathBuf),
    /// Its file system has no locks.
    #[error(
        "cannot lock {}: its file system has no locks, so nothing would keep two runs apart; {remedy}", path.display()
    )]
    NoLocks {
        /// The folder.
        path: PathBuf,
        /// What to do.
        remedy: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// Another process writes to it.
    #[error("{} is in use by another run{holder}; choose another folder with --out", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
        /// Who that is, as far as it is known.
        holder: Holder,
    },
    /// Its entries cannot be listed.
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
    /// It belongs to another plan.
    #[error(
        "{} holds the results of another plan; choose another folder with --out", .0.display()
    )]
    OtherPlan(PathBuf),
    /// No folder has this plan.
    #[error(
        "no folder in {RESULTS}/ has this plan, so there is nothing to continue; to begin, omit \
         --resume and --failed, or name a folder with --out"
    )]
    NoneBegun,
    /// Its sweep's rows were made otherwise.
    #[error(
        "{} has rows that were made {maker}; choose another folder with --out", path.display()
    )]
    OtherMaker {
        /// The folder.
        path: PathBuf,
        /// By whom, or with what.
        maker: &'static str,
    },
    /// A row of the sweep is damaged.
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
    /// A file without a whole line cannot be removed.
    #[error("cannot write {}", path.display())]
    NotRemoved {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Something in it that should be a folder is not one.
    #[error(transparent)]
    NoFolder(io::Error),
    /// Its identity file cannot be written.
    #[error(transparent)]
    Write(#[from] Unwritable),
    /// A file in it can no longer be written.
    #[error(transparent)]
    Full(#[from] FullError),
}

/// A file of a folder can no longer be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}; free space and run the same command again", path.display())]
pub struct FullError {
    pub(crate) path: PathBuf,
    pub(crate) source: io::Error,
}
