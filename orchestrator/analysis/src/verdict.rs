//! Whether a loop holds: the one rule, for every table, figure, clause and page.
//!
//! It judges an output from the step to the planned end of the run, whatever arrived: what the plant does after
//! its link or its controller has gone is part of the answer. `docs/holding.md` is the same rule in words.
//! Pure: [`response`](crate::response) has the samples, [`silence`](crate::silence) says who was silent.

mod fifth;
mod place;
mod rule;

use std::fmt;

use serde::{Deserialize, Serialize};
use text::column::{EntryType, Typed};

use crate::asked::Task;
use crate::reason::Reason;
use crate::silence::Silence;

pub use fifth::PARTS;
pub(crate) use fifth::part;
pub use rule::{judge, judge_following, judge_free};

/// The verdict on a closed loop, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopVerdict {
    /// Tracking: y settled and stayed. Regulation: y stayed within its band.
    #[serde(alias = "stable")]
    Holds,
    /// It holds, with more overshoot, excursion or effort than is asked.
    HoldsBadly,
    /// y is not within its band at the end, and its error does not grow either.
    #[serde(alias = "not-settled")]
    Unsettled,
    /// No command came for so long that the plant was on its own at the end.
    Silent,
    /// The error grows, y left its limits, or y is not finite.
    #[serde(alias = "unstable")]
    Lost,
}

impl LoopVerdict {
    /// All verdicts, from the best to the worst.
    pub const ALL: [LoopVerdict; 5] = [
        LoopVerdict::Holds,
        LoopVerdict::HoldsBadly,
        LoopVerdict::Unsettled,
        LoopVerdict::Silent,
        LoopVerdict::Lost,
    ];

    /// Whether it holds, well or badly.
    #[must_use]
    pub fn is_held(self) -> bool {
        self <= LoopVerdict::HoldsBadly
    }
}

impl Typed for LoopVerdict {
    const ENTRY: EntryType = EntryType::String;
    const WORDS: &'static [&'static str] = &["holds", "holds-badly", "unsettled", "silent", "lost"];
}

impl fmt::Display for LoopVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            LoopVerdict::Holds => "holds",
            LoopVerdict::HoldsBadly => "holds badly",
            LoopVerdict::Unsettled => "does not settle",
            LoopVerdict::Silent => "silent",
            LoopVerdict::Lost => "lost",
        })
    }
}

/// An output from a step to the end of the run.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a> {
    /// The errors y - r, a sample every h.
    pub error: &'a [f64],
    /// The same samples of y itself.
    pub y: &'a [f64],
    /// From one sample to the next, s.
    pub h_s: f64,
    /// The step: how far r is from where y was before.
    pub step: f64,
    /// What the loop is for.
    pub task: Task,
    /// Samples at the end without a new command.
    pub open: usize,
    /// The overshoot, % of the step; `None` if it has none.
    pub overshoot_pct: Option<f64>,
    /// The greatest magnitude of the input.
    pub effort: f64,
    /// Whose silence the run ended with, if it did.
    pub silence: Option<Silence>,
}

/// What the rule finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// The verdict.
    pub verdict: LoopVerdict,
    /// Why it does not just hold; `None` if it does, or the samples are too few to say more.
    pub reason: Option<Reason>,
    /// When the loop was lost, s from the step; `None` if it was not, or no sample says when.
    pub lost_s: Option<f64>,
}

impl Finding {
    fn of(verdict: LoopVerdict, reason: Reason) -> Finding {
        Finding {
            verdict,
            reason: Some(reason),
            lost_s: None,
        }
    }

    fn lost(reason: Reason, lost_s: Option<f64>) -> Finding {
        Finding {
            lost_s,
            ..Finding::of(LoopVerdict::Lost, reason)
        }
    }

    const HOLDS: Finding = Finding {
        verdict: LoopVerdict::Holds,
        reason: None,
        lost_s: None,
    };

    /// The worse of two outputs' findings, the first where they are equal.
    #[must_use]
    pub fn worse(self, other: Finding) -> Finding {
        if other.verdict > self.verdict {
            other
        } else {
            self
        }
    }
}
