//! Why trials could not be run at all; what a controller does wrong is a `fault`.

use std::io;
use std::path::PathBuf;

use control::InvalidDiscretisation;

/// The trials could not be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system refused a thread, a runtime or a socket.
    #[error("cannot run a trial: {0}")]
    System(#[from] io::Error),
    /// A controller's folder cannot be made.
    #[error("cannot make the folder {path}: {source}; free space or choose another folder")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A controller's supervisor cannot be started.
    #[error(transparent)]
    Role(#[from] process::Error),
    /// The motor cannot be sampled at this h.
    #[error(transparent)]
    Motor(#[from] InvalidDiscretisation),
    /// This machine lacks something that a controller's supervisor needs.
    #[error("{0}")]
    Lacking(String),
    /// The caller ended the trials.
    #[error("the trials were interrupted")]
    Interrupted,
}
