//! Why a run did not finish.

use std::path::Path;

use plan::NoSystem;
use plan::system::Unfit;
use record::ReadError;
use record::folder::Unwritable;

/// Why a run could not be made or finished.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// This machine cannot do it; says what is missing and the remedy.
    #[error("{0}")]
    Unsupported(String),
    /// The folder of the results cannot be written.
    #[error(transparent)]
    Folder(#[from] Unwritable),
    /// One of the processes of the run failed.
    #[error("the {role} {problem}")]
    Role {
        /// Name of the role.
        role: String,
        /// What happened.
        problem: String,
    },
    /// A program of one's own did not do its part; says which one.
    #[error("{0}")]
    Program(String),
    /// The plan has no profile for the cell, or none that can be played.
    #[error("{0}")]
    Profile(String),
    /// The plan has no system for the cell.
    #[error(transparent)]
    System(#[from] NoSystem),
    /// The cell's system cannot run at its sample time.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The link could not be made, or what plays it failed.
    #[error("{0}")]
    Link(String),
    /// The empty link was not measured.
    #[error("{0}")]
    Echoes(String),
    /// Rows that the run has left cannot be read.
    #[error("cannot read this run's rows to judge them: {0}")]
    Rows(#[from] ReadError),
    /// A part that outlives the controller ended before it.
    #[error("the plant or the link ended before the controller")]
    Ended,
    /// The parts were not ready when the link opened, or its empty state had not been measured.
    #[error(
        "this machine was too busy to start the parts and to measure the empty link before the run"
    )]
    Late,
    /// An agent did not do its part; says which one.
    #[error("{0}")]
    Agent(String),
    /// The run was asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl RunError {
    pub(crate) fn role(role: &str, problem: impl Into<String>) -> Self {
        RunError::Role {
            role: role.to_owned(),
            problem: problem.into(),
        }
    }

    /// The error of a role that ended since something is missing, by the last words of its log.
    pub(crate) fn lacking(role: &str, words: &str) -> Self {
        RunError::Unsupported(format!(
            "the {role}: {}",
            words.replacen("webloop: ", "", 1)
        ))
    }

    pub(crate) fn write(path: &Path, problem: std::io::Error) -> Self {
        Unwritable::failed(path, problem).into()
    }
}

impl From<process::Error> for RunError {
    fn from(error: process::Error) -> Self {
        match error {
            process::Error::Role { role, problem } => RunError::Role { role, problem },
            process::Error::Lacking { role, words } => RunError::lacking(&role, &words),
        }
    }
}

impl From<containers::Error> for RunError {
    fn from(error: containers::Error) -> Self {
        match error {
            containers::Error::Refused {
                kind: containers::ProblemKind::Unsupported,
                ..
            } => RunError::Unsupported(error.to_string()),
            containers::Error::Write { path, source } => RunError::write(&path, source),
            other => RunError::Agent(other.to_string()),
        }
    }
}

impl From<shaper::Error> for RunError {
    fn from(error: shaper::Error) -> Self {
        RunError::from(&error)
    }
}

impl From<&shaper::Error> for RunError {
    fn from(error: &shaper::Error) -> Self {
        match error {
            shaper::Error::Unsupported { .. } => RunError::Unsupported(error.to_string()),
            shaper::Error::Failed { .. } => RunError::Link(error.to_string()),
        }
    }
}
