//! Why a file of rows could not be read: which file, where in it, and what is wrong.

use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a file of rows could not be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; a cell that has run has this file in its folder")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file does not have the expected columns.
    #[error("{path} has the columns {found}, and this version of webloop reads {expected}")]
    Columns {
        /// The file.
        path: PathBuf,
        /// Its header.
        found: String,
        /// The header that its rows need.
        expected: String,
    },
    /// A line is not a row.
    #[error(
        "{path}, line {line}: {problem}; rows are never edited, so restore the file or run the cell again"
    )]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, from 1; the header is line 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// The file does not match its manifest.
    #[error("{path}: {problem}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

impl ReadError {
    /// The path of the file, and what is wrong with the file.
    pub(crate) fn parts(self) -> (PathBuf, String) {
        match self {
            ReadError::File { path, source } if source.kind() == ErrorKind::NotFound => {
                (path, "it is gone".to_owned())
            }
            ReadError::File { path, source } => (path, source.to_string()),
            ReadError::Columns {
                path,
                found,
                expected,
            } => (
                path,
                format!("it has the columns {found}, and its rows have {expected}"),
            ),
            ReadError::Row {
                path,
                line,
                problem,
            } => (path, format!("line {line}: {problem}")),
            ReadError::Damaged { path, problem } => (path, problem),
        }
    }
}

/// The error of a file that cannot be read, from the system's.
pub(super) fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> ReadError {
    move |source| ReadError::File {
        path: path.to_owned(),
        source,
    }
}

/// The error of a line that is not a row.
pub(super) fn refused(path: &Path, line: u64, problem: &dyn Display) -> ReadError {
    ReadError::Row {
        path: path.to_owned(),
        line,
        problem: problem.to_string(),
    }
}
