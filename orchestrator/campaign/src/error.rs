//! Why something of a campaign or a sweep could not be done, and whose fault that is.

use std::io;
use std::path::PathBuf;

use analysis::{CampaignError, Damage, ReadError};
use backend::RunError;
use compose::Problem;
use plan::Client;

use crate::merge::MergeError;
use crate::open_error::{FullError, OpenError};

/// Why it could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A folder cannot be opened for what is asked.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A file of the folder cannot be written any more.
    #[error(transparent)]
    Full(#[from] FullError),
    /// Folders cannot be merged.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// What is there was made otherwise than is asked now.
    #[error(
        "{}: the {what} is {earlier}, and now {own} is asked for; a folder holds runs of one kind, so \
         choose another with --out", manifest.display()
    )]
    OtherKind {
        /// The earlier run's manifest.
        manifest: PathBuf,
        /// In what it differs.
        what: &'static str,
        /// What it was.
        earlier: String,
        /// What is asked for.
        own: String,
    },
    /// Files of a campaign are damaged: no figure of it is to be believed.
    #[error(
        "{0} is not whole: {count} of its files are damaged or missing; restore them, or run their \
         cells again with `webloop run .. --out {0} --failed`",
        folder.display(), count = damage.len()
    )]
    NotWhole {
        /// The campaign's folder.
        folder: PathBuf,
        /// Each of the files.
        damage: Vec<Damage>,
    },
    /// A cell that was to be run has a folder that is damaged; names the files.
    #[error("{0}; restore it, or move the cell's folder away to have it run again")]
    DamagedCell(String),
    /// A folder is no campaign's.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// A manifest cannot be read; names it.
    #[error("{0}")]
    Manifest(String),
    /// A cell's process cannot be started or waited for.
    #[error("cannot {step} a cell's process")]
    Process {
        /// What was tried.
        step: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// A cell could not even be recorded.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The container engine, or Compose, did not do its part.
    #[error(transparent)]
    Compose(#[from] Problem),
    /// The containers ended, and cells have no manifest.
    #[error("the containers ended before the cells did")]
    Unfinished {
        /// What was said last.
        source: Box<dyn std::error::Error + Send + Sync>,
        /// The orchestrator's exit code in there, where it had one.
        code: Option<i32>,
    },
    /// The environment names no agents.
    #[error(
        "--backend attach needs agents, and {variable} is not set; docker-compose.yml sets it, and \
         `webloop run --backend compose` uses that"
    )]
    NoAgents {
        /// The variable that has them.
        variable: &'static str,
    },
    /// The environment names agents that are not understood.
    #[error("{variable}: {problem}")]
    BadAgents {
        /// The variable.
        variable: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// The environment has a token that is none.
    #[error(transparent)]
    BadToken(#[from] agent::BadToken),
    /// The folder whose owner is asked for is not there.
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
    /// A campaign does not show what a client takes.
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
    Unfit(#[from] sweep::Unfit),
    /// A sweep does not read its own rows.
    #[error("{0}")]
    Row(String),
    /// A value has no JSON text.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// Anything else that the system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Whose fault it is: what an exit code tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// What is asked for, or a file that it names, is wrong.
    Usage,
    /// This machine lacks something.
    Unsupported,
    /// Something went wrong while it was done.
    Failed,
    /// Another webloop ended with this exit code, and said why.
    Other(i32),
}

impl Error {
    /// Whose fault it is.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Error::Open(_)
            | Error::OtherKind { .. }
            | Error::NoAgents { .. }
            | Error::BadAgents { .. }
            | Error::BadToken(_)
            | Error::NoOwner { .. }
            | Error::Compose(Problem::Usage(_)) => Kind::Usage,
            Error::Merge(problem) if problem.is_usage() => Kind::Usage,
            Error::Compose(Problem::Unsupported { .. }) | Error::NotOwner { .. } => {
                Kind::Unsupported
            }
            Error::Unfinished {
                code: Some(code), ..
            } => Kind::Other(*code),
            _ => Kind::Failed,
        }
    }
}
