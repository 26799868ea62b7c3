//! Why a run did not come to its end.

use std::path::Path;

/// A run that could not be made or finished.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// This machine cannot do it; says what is missing and the remedy.
    #[error("{0}")]
    Unsupported(String),
    /// A file of the results could not be written.
    #[error("cannot write {path}: {problem}; free space or choose another folder with --out")]
    Write {
        /// The file or folder.
        path: String,
        /// What the system said.
        problem: std::io::Error,
    },
    /// One of the processes of the run failed.
    #[error("the {role} {problem}")]
    Role {
        /// Which one.
        role: &'static str,
        /// What happened.
        problem: String,
    },
    /// The link could not be made or probed.
    #[error("{0}")]
    Link(String),
    /// The run was asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl RunError {
    pub(crate) fn role(role: &'static str, problem: impl Into<String>) -> Self {
        RunError::Role {
            role,
            problem: problem.into(),
        }
    }

    pub(crate) fn write(path: &Path, problem: std::io::Error) -> Self {
        RunError::Write {
            path: path.display().to_string(),
            problem,
        }
    }
}

impl From<shaper::Error> for RunError {
    fn from(error: shaper::Error) -> Self {
        match error {
            shaper::Error::Unsupported { .. } => RunError::Unsupported(error.to_string()),
            shaper::Error::Failed { .. } => RunError::Link(error.to_string()),
        }
    }
}
