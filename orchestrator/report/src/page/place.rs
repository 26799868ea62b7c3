//! Where a run is in the page, and what is said of it there without the way to its folder.

use std::fmt::Write as _;

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

/// A message without the way to the folder that was read: the page is the same wherever that is.
pub(super) fn without_folder(campaign: &Campaign, message: &str) -> String {
    let mut folder = campaign.folder.display().to_string();
    if folder.is_empty() {
        return message.to_owned();
    }
    if !folder.ends_with('/') {
        let _ = folder.write_char('/');
    }
    message.replace(&folder, "")
}

/// Whether a run left something to look at.
pub(super) fn was_made(run: &Run) -> bool {
    run.verdict()
        .is_some_and(|verdict| verdict != Verdict::Unsupported)
}
