//! What a plant did that its contract does not allow, with the numbers and what to do about it.

use endpoint::{SampleTime, Signals};

/// A breach of the contract of plants.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantFault {
    /// It did not answer as it should; a sentence about it.
    #[error("{0}")]
    Broken(String),
    /// It printed infinity or nan.
    #[error(
        "y is {y} after {steps} steps, the last under u = {u}; print a finite number for each finite u"
    )]
    NotFinite {
        /// Number of steps.
        steps: usize,
        /// The input of the last.
        u: f64,
        /// Its output.
        y: Signals,
    },
    /// Its steps take too long.
    #[error(
        "{slow} of {steps} steps took longer than h = {h}, and {slowest_ms:.1} ms at the most; step faster, or test with a longer --h"
    )]
    Slow {
        /// Steps that took longer than h.
        slow: u64,
        /// All steps.
        steps: u64,
        /// The sample time.
        h: SampleTime,
        /// How long the slowest took, ms.
        slowest_ms: f64,
    },
    /// Two programs do not step alike.
    #[error("{pair} differ: after the same {steps} inputs y is {one} and {other}; {remedy}")]
    Differs {
        /// Which two.
        pair: &'static str,
        /// Number of inputs.
        steps: usize,
        /// An output.
        one: f64,
        /// The other.
        other: f64,
        /// What to do about it.
        remedy: &'static str,
    },
    /// It steps alike whatever h is.
    #[error(
        "y is the same for h = {h} and h = {other}, step by step; advance by WEBLOOP_H_S seconds at a step"
    )]
    IgnoresH {
        /// A sample time.
        h: SampleTime,
        /// Another.
        other: SampleTime,
    },
    /// It did not end well.
    #[error("it ended with exit code {code} when its input ended; end with exit code 0 then")]
    Code {
        /// Its exit code.
        code: i32,
    },
    /// It did not end with its input.
    #[error(
        "it still ran 1 s after its input had ended, and was killed; end when there is no further line"
    )]
    RanOn,
}
