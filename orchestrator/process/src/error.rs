//! Errors of a role.

/// A role could not be started, or did not end well.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A role could not be started, or did not end well.
    #[error("the {role} {problem}")]
    Role {
        /// The role that failed.
        role: String,
        /// What happened.
        problem: String,
    },
    /// A role ended since something is missing, or since a program of somebody's own does not support what it was
    /// told.
    #[error("the {role}: {words}")]
    Lacking {
        /// The role.
        role: String,
        /// Its last words.
        words: String,
    },
}

impl Error {
    pub(crate) fn role(role: &str, problem: impl Into<String>) -> Self {
        Error::Role {
            role: role.to_owned(),
            problem: problem.into(),
        }
    }
}
