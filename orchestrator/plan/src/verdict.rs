//! How a run ended: the five words that every manifest, table and exit code use.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

text::choice!(
    /// The verdict on a run, not on the loop: a loop that goes unstable over a link that held is a
    /// `complete` run with a result.
    Verdict, "verdict", {
        /// It ran to its end, and its link held.
        Complete = "complete",
        /// This machine cannot run it; the reason says what is missing.
        Unsupported = "unsupported",
        /// It ran over the link that was asked for, but something was done to it that the experiment
        /// did not ask for: the machine stood still, an end or the player was stopped or starved. Shown
        /// and marked, and left out of medians.
        Disturbed = "disturbed",
        /// It ran, but its link was not the one asked for, or rows were lost: not to be plotted.
        Invalid = "invalid",
        /// It did not run to its end.
        Failed = "failed",
    }
);

/// Something that was done to a run and that its experiment did not ask for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// What was held up, in a word or two: `plant`, `player`, `machine`.
    pub what: String,
    /// When it began, or was worst: seconds after the controller's first deadline.
    pub at_s: f64,
    /// How long the longest one lasted, ms.
    pub longest_ms: f64,
    /// All of it in a sentence, with its limit.
    pub words: String,
}

impl std::fmt::Display for Disturbance {
    /// Short form for tables: `player 298 ms at 2.1 s`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            what,
            at_s,
            longest_ms,
            ..
        } = self;
        write!(f, "{what} {longest_ms:.0} ms at {at_s:.1} s")
    }
}
