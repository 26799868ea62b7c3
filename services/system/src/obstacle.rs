//! What keeps a system from being run at a sample time.

use control::{InvalidDiscretisation, InvalidLaw};

/// What keeps a system from a sample time.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Obstacle {
    /// The plant or the law cannot be sampled.
    #[error(transparent)]
    Sampling(#[from] InvalidDiscretisation),
    /// The law does not come out.
    #[error(transparent)]
    Law(#[from] InvalidLaw),
    /// Dead time and round trip are more ticks than a law can look past.
    #[error("a law `{law}` would have to look past {ticks} ticks, and can at most past {most}")]
    Ticks {
        /// Which law.
        law: &'static str,
        /// As many as dead time and round trip are.
        ticks: usize,
        /// As many as it can.
        most: usize,
    },
}
