//! Where a run is in the page.

use analysis::{Campaign, Run};
use plan::Verdict;

/// Where a run's details are in the page. Its index is unique in a plan, and always a word.
pub(super) fn anchor(run: &Run) -> String {
    format!("run-{}", run.cell.index)
}

/// The same of a cell's id; `None` where the plan has no such cell.
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
