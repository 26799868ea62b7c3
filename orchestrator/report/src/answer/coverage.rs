//! How much of a campaign there is.

use analysis::Campaign;
use plan::Verdict;

use super::words::listed;

/// How the runs of a campaign ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Coverage {
    /// Runs that the plan asks for.
    pub planned: usize,
    /// Those that came to their end over a link that held, with rows that can be read.
    pub complete: usize,
    /// Those that something was done to.
    pub disturbed: usize,
    /// Those whose link did not hold, or that lost rows.
    pub invalid: usize,
    /// Those that did not come to their end.
    pub failed: usize,
    /// Those that the machine could not do.
    pub unsupported: usize,
    /// Those whose folder is damaged.
    pub unreadable: usize,
    /// Those that have not been run here.
    pub absent: usize,
}

impl Coverage {
    pub(super) fn of(campaign: &Campaign) -> Coverage {
        let mut coverage = Coverage {
            planned: campaign.runs.len(),
            ..Coverage::default()
        };
        for run in &campaign.runs {
            let count = match run.verdict() {
                _ if !run.damage.is_empty() => &mut coverage.unreadable,
                None => &mut coverage.absent,
                Some(Verdict::Complete) => &mut coverage.complete,
                Some(Verdict::Disturbed) => &mut coverage.disturbed,
                Some(Verdict::Invalid) => &mut coverage.invalid,
                Some(Verdict::Failed) => &mut coverage.failed,
                Some(Verdict::Unsupported) => &mut coverage.unsupported,
            };
            *count += 1;
        }
        coverage
    }

    /// `Of 248 runs 240 are complete, 5 failed and 3 were not made.`
    #[must_use]
    pub fn words(&self) -> String {
        if self.complete == self.planned {
            return match self.planned {
                0 => "The plan has no runs.".to_owned(),
                1 => "The one run is complete.".to_owned(),
                2 => "Both runs are complete.".to_owned(),
                n => format!("All {n} runs are complete."),
            };
        }
        let some = |n: usize, one: &str, more: &str| match n {
            0 => None,
            1 => Some(format!("1 {one}")),
            n => Some(format!("{n} {more}")),
        };
        let parts: Vec<String> = [
            some(self.complete, "is complete", "are complete")
                .or_else(|| Some("none is complete".to_owned())),
            some(self.disturbed, "was disturbed", "were disturbed"),
            some(self.invalid, "is invalid", "are invalid"),
            some(self.failed, "failed", "failed"),
            some(self.unsupported, "is unsupported", "are unsupported"),
            some(self.unreadable, "cannot be read", "cannot be read"),
            some(self.absent, "was not made", "were not made"),
        ]
        .into_iter()
        .flatten()
        .collect();
        let runs = match self.planned {
            1 => "run",
            _ => "runs",
        };
        format!("Of {} {runs} {}.", self.planned, listed(&parts))
    }
}
