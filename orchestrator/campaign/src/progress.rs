//! What is told of how a campaign goes. How it is shown is the caller's.

use plan::{Cell, Verdict};

/// Whoever wants to know; cells that run side by side are told of from several threads.
pub trait Progress: Sync {
    /// Something takes its time that is no cell.
    fn say(&self, words: &str);
    /// A cell has been begun.
    fn on_begun(&self, cell: &Cell);
    /// A cell that was begun is not waited for any more, however that came.
    fn on_left(&self, cell: &Cell);
    /// A cell has ended, and why so where it is not complete.
    fn on_ended(&self, cell: &Cell, verdict: Verdict, reason: &str);
}

/// A cell under way, until it is dropped.
pub(crate) struct Begun<'a> {
    progress: &'a dyn Progress,
    cell: &'a Cell,
}

impl<'a> Begun<'a> {
    pub(crate) fn new(progress: &'a dyn Progress, cell: &'a Cell) -> Begun<'a> {
        progress.on_begun(cell);
        Begun { progress, cell }
    }
}

impl Drop for Begun<'_> {
    fn drop(&mut self) {
        self.progress.on_left(self.cell);
    }
}
