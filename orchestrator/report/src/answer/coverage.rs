//! How much of a campaign has been run.

use analysis::Campaign;

use super::words::listed;
use crate::outcome::Kind;

/// How the runs of a campaign ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage(Vec<Kind>);

impl Coverage {
    pub(super) fn of(campaign: &Campaign) -> Coverage {
        Coverage(campaign.runs.iter().map(Kind::of).collect())
    }

    /// `Of 248 runs 240 are complete, 5 failed and 3 were not made.`
    #[must_use]
    pub fn words(&self) -> String {
        let planned = self.0.len();
        let count = |kind| self.0.iter().filter(|of| **of == kind).count();
        if count(Kind::Complete) == planned {
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
            some(Kind::Complete, "is complete", "are complete")
                .or_else(|| Some("none is complete".to_owned())),
            some(Kind::Disturbed, "was disturbed", "were disturbed"),
            some(Kind::Invalid, "is invalid", "are invalid"),
            some(Kind::Failed, "failed", "failed"),
            some(Kind::Unsupported, "is unsupported", "are unsupported"),
            some(Kind::Damaged, "cannot be read", "cannot be read"),
            some(Kind::NotRun, "was not made", "were not made"),
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
