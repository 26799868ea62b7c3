//! Errors of setting up, playing or probing a link.

use std::io;

/// Why the shaper could not do what was asked.
///
/// The two kinds mean different things to a campaign: [`Unsupported`](Error::Unsupported) will be the
/// same on every attempt and is an outcome of its own, while a [`Failed`](Error::Failed) step is a
/// failure of this run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// This machine, or this user on it, lacks something that the shaper needs.
    #[error("this machine does not let webloop {action} ({source}): {remedy}")]
    Unsupported {
        /// What was tried, as a verb phrase.
        action: &'static str,
        /// What the owner of the machine can do about it.
        remedy: &'static str,
        /// The kernel's answer.
        source: io::Error,
    },
    /// A step failed that this machine should be able to do.
    #[error("cannot {action}: {source}")]
    Failed {
        /// What was tried, as a verb phrase.
        action: String,
        /// The kernel's answer.
        source: io::Error,
    },
}

/// The result of a step of the shaper.
pub type Result<T> = std::result::Result<T, Error>;

/// Adds what was being done to an error of the kernel.
pub(crate) trait Doing<T> {
    /// Turns an error into [`Error::Failed`], with `action` as a verb phrase.
    fn doing(self, action: &'static str) -> Result<T>;

    /// The same with an action that is formatted only if there is an error.
    fn doing_with(self, action: impl FnOnce() -> String) -> Result<T>;
}

impl<T, E: Into<io::Error>> Doing<T> for std::result::Result<T, E> {
    fn doing(self, action: &'static str) -> Result<T> {
        self.doing_with(|| action.to_owned())
    }

    fn doing_with(self, action: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|source| Error::Failed {
            action: action(),
            source: source.into(),
        })
    }
}
