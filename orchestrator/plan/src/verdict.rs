//! How a run ended: the four words that every manifest, table and exit code use.

use serde::{Deserialize, Serialize};

/// The verdict on a run, not on the loop: a loop that goes unstable over a link that held is a
/// `complete` run with a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It ran to its end, and its link held.
    Complete,
    /// This machine cannot run it; the reason says what is missing.
    Unsupported,
    /// It ran, but its link was not the one asked for, or rows were lost: not to be plotted.
    Invalid,
    /// It did not run to its end.
    Failed,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Verdict::Complete => "complete",
            Verdict::Unsupported => "unsupported",
            Verdict::Invalid => "invalid",
            Verdict::Failed => "failed",
        })
    }
}
