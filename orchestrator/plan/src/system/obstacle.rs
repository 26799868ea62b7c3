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
    #[error(
        "its plant is a program, and {what} needs a linear model of it; give the plant as num and den or as matrices, \
         or a law without a model"
    )]
    NoModel {
        /// What needs the model.
        what: &'static str,
    },
    /// Dead time and round trip have more ticks than the law can span.
    #[error(
        "law `{law}` must span {ticks} ticks of dead time and round trip; the limit is {most}: give a longer h, or a \
         shorter round_trip"
    )]
    Ticks {
        /// Name of the law.
        law: &'static str,
        /// Dead time and round trip, in ticks.
        ticks: usize,
        /// Most ticks that the law can span.
        most: usize,
    },
}

/// Checks that a law spans at most `most` ticks of dead time and round trip.
pub(crate) fn within(law: &'static str, ticks: usize, most: usize) -> Result<usize, Obstacle> {
    if ticks <= most {
        Ok(ticks)
    } else {
        Err(Obstacle::Ticks { law, ticks, most })
    }
}
