//! How much of a campaign has been run.

use analysis::Campaign;

use super::words::listed;
use crate::outcome::OutcomeKind;

/// How the runs of a campaign ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage(Vec<OutcomeKind>);

impl Coverage {
    /// Of all runs of the plan.
    #[must_use]
    pub fn of(campaign: &Campaign) -> Coverage {
        Coverage(campaign.runs.iter().map(OutcomeKind::of).collect())
    }

    /// How many runs the plan has.
    pub(super) fn planned(&self) -> usize {
        self.0.len()
    }

    /// `Of 248 runs 240 are complete, 5 failed and 3 were not made.`
    #[must_use]
    pub fn words(&self) -> String {
        let planned = self.0.len();
        let count = |kind| self.0.iter().filter(|of| **of == kind).count();
        if count(OutcomeKind::Complete) == planned {
            return match planned {
                0 => "The plan has no runs.".to_owned(),
                1 => "The one run is complete.".to_owned(),
                2 => "Both runs are complete.".to_owned(),
                n => format!("All {n} runs are complete."),
            };
        }
        let some = |kind, one: &str, more: &str| match count(kind) {
            0 => None,
            1 => Some(format!("1 {one}")),
            n => Some(format!("{n} {more}")),
        };
        let parts: Vec<String> = [
            some(OutcomeKind::Complete, "is complete", "are complete")
                .or_else(|| Some("none is complete".to_owned())),
            some(OutcomeKind::Disturbed, "was disturbed", "were disturbed"),
            some(OutcomeKind::Invalid, "is invalid", "are invalid"),
            some(OutcomeKind::Failed, "failed", "failed"),
            some(
                OutcomeKind::Unsupported,
                "is unsupported",
                "are unsupported",
            ),
            some(OutcomeKind::Damaged, "cannot be read", "cannot be read"),
            some(OutcomeKind::NotRun, "was not made", "were not made"),
        ]
        .into_iter()
        .flatten()
        .collect();
        let runs = match planned {
            1 => "run",
            _ => "runs",
        };
        format!("Of {planned} {runs} {}.", listed(&parts))
    }
}
