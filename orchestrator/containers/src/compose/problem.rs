//! What can go wrong between webloop and the container engine.

/// Why the engine, Compose or a project could not be used.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// This machine lacks something that containers need; trying again will not help.
    #[error("{lack}; {remedy}")]
    Unsupported {
        /// The missing requirement.
        lack: String,
        /// What the owner of the machine can do about it.
        remedy: &'static str,
    },
    /// A folder or file that was given is not what it should be.
    #[error("{0}")]
    Usage(String),
    /// A step that should have worked did not.
    #[error("cannot {action}: {words}")]
    Failed {
        /// What was tried, as a verb phrase.
        action: String,
        /// What docker said last, or what the system did.
        words: String,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl Problem {
    pub(crate) fn lacks(lack: impl Into<String>, remedy: &'static str) -> Self {
        Problem::Unsupported {
            lack: lack.into(),
            remedy,
        }
    }

    pub(crate) fn failed(action: impl Into<String>, words: &(impl ToString + ?Sized)) -> Self {
        Problem::Failed {
            action: action.into(),
            words: words.to_string(),
        }
    }
}
