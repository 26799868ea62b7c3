//! What ends the program before it is done, in words, and the exit code of each. What only keeps a contender from
//! being measured is a `Lack`, and ends nothing.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use record::folder::Unwritable;

use crate::end::EndError;

/// How webloop is built beside this program, in the same profile.
const BUILD: &str = if cfg!(debug_assertions) {
    "cargo build"
} else {
    "cargo build --release"
};

/// Why nothing, or nothing more, is measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BenchError {
    /// No binary `webloop` at this path.
    #[error(
        "there is no webloop at {path}; build it by `{BUILD}`, or give --webloop the path of another one",
        path = path.display()
    )]
    NoWebloop { path: PathBuf },
    /// The working folder or this program's own path is unknown.
    #[error("cannot find this program: {0}")]
    Lost(io::Error),
    /// The folder for figures cannot be made.
    #[error("cannot make the folder {}: {problem}; give --out another one", folder.display())]
    NoFolder { folder: PathBuf, problem: io::Error },
    /// The folder has figures already.
    #[error("{} has figures of an earlier run; give --out another folder", folder.display())]
    Earlier { folder: PathBuf },
    /// A file of figures cannot be written.
    #[error(transparent)]
    Unwritten(#[from] Unwritable),
    /// The description of this machine is no JSON.
    #[error("cannot describe this machine: {0}")]
    Machine(serde_json::Error),
    /// There is no temporary folder, or no processor that is known.
    #[error("cannot begin to measure: {0}")]
    NoPlace(io::Error),
    /// Signals cannot be heeded.
    #[error("cannot heed signals: {0}")]
    Signals(io::Error),
    /// A table cannot be printed.
    #[error("standard output cannot be written: {0}")]
    Output(io::Error),
    /// An end of a peer could not be started, or broke off.
    #[error(transparent)]
    End(#[from] EndError),
}

impl BenchError {
    /// Whether it only says that nobody reads on, as in `webloop-bench | head`, which is no error.
    pub(crate) fn is_unread(&self) -> bool {
        matches!(self, BenchError::Output(problem) if problem.kind() == io::ErrorKind::BrokenPipe)
    }

    /// 2 if the command line is wrong, or a path that it names; else 1.
    pub(crate) fn code(&self) -> ExitCode {
        let code = match self {
            BenchError::NoWebloop { .. }
            | BenchError::NoFolder { .. }
            | BenchError::Earlier { .. }
            | BenchError::End(EndError::Unknown(_)) => 2,
            BenchError::Lost(_)
            | BenchError::Unwritten(_)
            | BenchError::Machine(_)
            | BenchError::NoPlace(_)
            | BenchError::Signals(_)
            | BenchError::Output(_)
            | BenchError::End(_) => 1,
        };
        ExitCode::from(code)
    }
}
