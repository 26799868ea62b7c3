//! Anchors of runs in the page.

use analysis::{Campaign, Run};
use plan::Verdict;

/// The anchor of a run's details. Its index is unique in a plan and valid in an anchor.
pub(super) fn anchor(run: &Run) -> String {
    format!("run-{}", run.cell.index)
}

/// The anchor for a cell's id; `None` if the plan has no such cell.
pub(super) fn anchor_of(campaign: &Campaign, id: &str) -> Option<String> {
    campaign
        .runs
        .iter()
        .find(|run| run.cell.id == id)
        .map(anchor)
}

/// Whether a run left something to look at.
pub(super) fn was_made(run: &Run) -> bool {
    run.verdict()
        .is_some_and(|verdict| verdict != Verdict::Unsupported)
}
