//! Errors of campaigns and sweeps, and whose fault they are.

use std::io;
use std::path::PathBuf;

use analysis::CampaignError;
use backend::{BadAgents, RunError};
use containers::compose::Problem;
use plan::Client;
use record::folder::Unwritable;
use record::{Damage, ReadError, Unreadable};

use crate::merge::MergeError;
use crate::open_error::{FullError, OpenError};

/// Why something with a campaign or a sweep failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A folder cannot be opened for this use.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A file of the folder cannot be written any more.
    #[error(transparent)]
    Full(#[from] FullError),
    /// Folders cannot be merged.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// An earlier run in the folder was made differently from what is requested now.
    #[error(
        "{}: the {what} is {earlier}, and now {own} is asked for; a folder holds runs of one kind, so \
         choose another with --out", manifest.display()
    )]
    OtherKind {
        /// The earlier run's manifest.
        manifest: PathBuf,
        /// Which property differs.
        what: &'static str,
        /// Its value in the earlier run.
        earlier: String,
        /// The requested value.
        own: String,
    },
    /// Files of a campaign are damaged, so none of its figures can be trusted.
    #[error(
        "{0} is not whole: {count} of its files are damaged or missing; restore them, or run their \
         cells again with `webloop run .. --out {0} --failed`",
        folder.display(), count = damage.len()
    )]
    NotWhole {
        /// The campaign's folder.
        folder: PathBuf,
        /// The damaged files.
        damage: Vec<Damage>,
    },
    /// A cell to be run has a damaged folder; the text names the files.
    #[error("{0}; restore it, or move the cell's folder away to have it run again")]
    DamagedCell(String),
    /// A folder does not hold a campaign.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// A manifest cannot be read.
    #[error(transparent)]
    Manifest(#[from] Unreadable),
    /// A cell's process cannot be started or waited for.
    #[error("cannot {step} a cell's process")]
    Process {
        /// The step that failed.
        step: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// A folder cannot be written.
    #[error(transparent)]
    Unwritable(#[from] Unwritable),
    /// A cell could not be run or recorded.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The container engine or Compose is missing or failed.
    #[error(transparent)]
    Compose(#[from] Problem),
    /// The containers ended before all cells had a manifest.
    #[error("the containers ended before the cells did")]
    Unfinished {
        /// Last words from the containers.
        source: Box<dyn std::error::Error + Send + Sync>,
        /// Exit code of the orchestrator in the containers, if it had one.
        code: Option<i32>,
    },
    /// The environment names no agents.
    #[error(
        "--backend attach needs agents, and {variable} is not set; docker-compose.yml sets it, and \
         `webloop run --backend compose` uses that"
    )]
    NoAgents {
        /// The variable that should name them.
        variable: &'static str,
    },
    /// The environment names agents in a form that is not understood.
    #[error("{variable}: {problem}")]
    BadAgents {
        /// The variable.
        variable: &'static str,
        /// What is wrong with it.
        problem: BadAgents,
    },
    /// The token in the environment is invalid.
    #[error(transparent)]
    BadToken(#[from] containers::BadToken),
    /// The folder whose owner is needed does not exist.
    #[error("cannot look at the results folder {}", folder.display())]
    NoOwner {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// This process may not become a folder's owner.
    #[error(
        "cannot become {owner}, the owner of {}: {problem}; give OWNER={owner}, or the capabilities \
         SETUID and SETGID", folder.display()
    )]
    NotOwner {
        /// The folder.
        folder: PathBuf,
        /// Its owner, as `UID:GID`.
        owner: String,
        /// What the system said.
        problem: io::Error,
    },
    /// A campaign lacks the runs that show a client's timings.
    #[error(
        "no complete closed loop of {client} over loopback is in {}; `webloop calibrate` without a \
         folder runs them", folder.display()
    )]
    NoRates {
        /// The client.
        client: Client,
        /// The campaign's folder.
        folder: PathBuf,
    },
    /// Rows of a run cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A point of a sweep cannot be run.
    #[error(transparent)]
    Unfit(#[from] crate::bench::Unfit),
    /// A sweep cannot read back one of its own rows.
    #[error("{0}")]
    Row(analysis::sweep::InvalidRow),
    /// A value cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// Any other error from the system.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Whose fault an error is; determines the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// The request, or a file that it names, is wrong.
    Usage,
    /// This machine lacks something.
    Unsupported,
    /// Something went wrong on the way.
    Failed,
    /// Another webloop ended with this exit code and has said why.
    Other(i32),
}

impl Error {
    /// Whose fault it is.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::Open(_)
            | Error::OtherKind { .. }
            | Error::NoAgents { .. }
            | Error::BadAgents { .. }
            | Error::BadToken(_)
            | Error::NoOwner { .. }
            | Error::Unwritable(Unwritable::InUse(_))
            | Error::Run(RunError::Folder(Unwritable::InUse(_)))
            | Error::Compose(Problem::Usage(_)) => ErrorKind::Usage,
            Error::Merge(problem) if problem.is_usage() => ErrorKind::Usage,
            Error::Compose(Problem::Unsupported { .. }) | Error::NotOwner { .. } => {
                ErrorKind::Unsupported
            }
            Error::Unfinished {
                code: Some(code), ..
            } => ErrorKind::Other(*code),
            _ => ErrorKind::Failed,
        }
    }
}
