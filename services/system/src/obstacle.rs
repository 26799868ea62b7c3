//! Why a system cannot run at a sample time.

use control::{InvalidDiscretisation, InvalidLaw};

/// Why a system cannot run at a sample time.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Obstacle {
    /// The plant or the law cannot be sampled.
    #[error(transparent)]
    Sampling(#[from] InvalidDiscretisation),
    /// The law cannot be computed.
    #[error(transparent)]
    Law(#[from] InvalidLaw),
    /// The plant is a program, and what is asked for needs a model of it.
    #[error("its plant is a program, and {what} needs a linear model of it")]
    NoModel {
        /// What needs the model.
        what: &'static str,
    },
    /// Dead time and round trip have more ticks than the law can span.
    #[error("law `{law}` must span {ticks} ticks of dead time and round trip; the limit is {most}")]
    Ticks {
        /// Name of the law.
        law: &'static str,
        /// Dead time and round trip, in ticks.
        ticks: usize,
        /// Most ticks that the law can span.
        most: usize,
    },
}
