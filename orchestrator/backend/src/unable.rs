//! Why a machine has not got an ability.

/// The reason, mostly in the words of its kernel or of a program that is missing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unable(String);

impl Unable {
    /// By its reason.
    #[must_use]
    pub fn new(why: impl Into<String>) -> Unable {
        Unable(why.into())
    }

    /// By what went wrong.
    #[must_use]
    pub fn by(problem: &impl ToString) -> Unable {
        Unable(problem.to_string())
    }
}
