//! How each cell of a campaign ended, in words for lists of failures.
//!
//! The words for a cell and for a claim's verdict are here too. How a cell ended is about the
//! testbed: a loop that goes unstable over a link that held is a result, and its cell is
//! [`Complete`](OutcomeKind::Complete).

use std::fmt::Write as _;

use analysis::{Campaign, Run};
use plan::Verdict;

use crate::claim;

/// How a cell ended, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellOutcome {
    /// How it ended.
    pub kind: OutcomeKind,
    /// Why, in one or more sentences; empty for a complete cell.
    pub reason: String,
}

/// How a cell ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutcomeKind {
    /// It ran to its end, its link held, and its rows are there.
    Complete,
    /// It ran over its link, but the machine held up a part of the run.
    Disturbed,
    /// It ran, but its link was not the one asked for, or rows were lost.
    Invalid,
    /// It did not run to its end.
    Failed,
    /// Its files cannot be read, or do not match its manifest.
    Damaged,
    /// The machine cannot run it.
    Unsupported,
    /// It has not been run here.
    NotRun,
}

impl OutcomeKind {
    /// All kinds, in the order in which tables show them.
    pub const ALL: [OutcomeKind; 7] = [
        OutcomeKind::Complete,
        OutcomeKind::Disturbed,
        OutcomeKind::Invalid,
        OutcomeKind::Failed,
        OutcomeKind::Damaged,
        OutcomeKind::Unsupported,
        OutcomeKind::NotRun,
    ];

    /// The kind of a run.
    #[must_use]
    pub fn of(run: &Run) -> OutcomeKind {
        match run.verdict() {
            _ if !run.damage.is_empty() => OutcomeKind::Damaged,
            None => OutcomeKind::NotRun,
            Some(Verdict::Complete) => OutcomeKind::Complete,
            Some(Verdict::Disturbed) => OutcomeKind::Disturbed,
            Some(Verdict::Invalid) => OutcomeKind::Invalid,
            Some(Verdict::Failed) => OutcomeKind::Failed,
            Some(Verdict::Unsupported) => OutcomeKind::Unsupported,
        }
    }

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            OutcomeKind::Complete => "complete",
            OutcomeKind::Disturbed => "disturbed",
            OutcomeKind::Invalid => "invalid",
            OutcomeKind::Failed => "failed",
            OutcomeKind::Damaged => "damaged",
            OutcomeKind::Unsupported => "unsupported",
            OutcomeKind::NotRun => "not run",
        }
    }
}

impl CellOutcome {
    /// The outcome of a run of this campaign.
    #[must_use]
    pub fn of(campaign: &Campaign, run: &Run) -> CellOutcome {
        let faults = run.damage.iter().map(|damage| {
            let name = damage.path.strip_prefix(&run.folder);
            let name = name.unwrap_or(&damage.path).display();
            without_folder(campaign, &format!("{name}: {}", damage.problem))
        });
        let faults: Vec<String> = faults.collect();
        let kind = OutcomeKind::of(run);
        let reasons = run.manifest.iter().flat_map(|manifest| &manifest.reasons);
        let reason = match kind {
            OutcomeKind::Damaged => faults.join("; "),
            OutcomeKind::NotRun => "it has not been run here".to_owned(),
            _ => reasons.cloned().collect::<Vec<_>>().join("; "),
        };
        CellOutcome { kind, reason }
    }
}

/// A cell in words, without its topology: `python, paper-python, closed, 333 Hz, repeat 1`.
#[must_use]
pub fn words(run: &Run) -> String {
    let cell = &run.cell;
    let (client, setup, rate) = (cell.client, &run.summary.setup, cell.rate());
    let (mode, repeat) = (cell.settings.mode, cell.repeat);
    format!("{client}, {setup}, {mode}, {rate}, repeat {repeat}")
}

/// The verdict on a claim, in a word or two.
#[must_use]
pub fn answered(verdict: claim::Verdict) -> &'static str {
    match verdict {
        claim::Verdict::Agrees => "agrees",
        claim::Verdict::Differs => "differs",
        claim::Verdict::CannotBeTold => "undecided",
        claim::Verdict::NotRun => "not run",
    }
}

/// The topologies of a campaign, in the order of its plan.
#[must_use]
pub fn topologies(campaign: &Campaign) -> Vec<&str> {
    let mut found = Vec::new();
    for run in &campaign.runs {
        if !found.contains(&run.cell.topology.as_str()) {
            found.push(run.cell.topology.as_str());
        }
    }
    found
}

/// A message without the path of the results folder, so that the page is the same wherever the folder
/// is.
pub(crate) fn without_folder(campaign: &Campaign, message: &str) -> String {
    let mut folder = campaign.folder.display().to_string();
    if folder.is_empty() {
        return message.to_owned();
    }
    if !folder.ends_with('/') {
        let _ = folder.write_char('/');
    }
    message.replace(&folder, "")
}
