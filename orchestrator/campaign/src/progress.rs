//! Progress events of a campaign. The caller decides how to show them.

use plan::{Cell, Verdict};

/// Receives the events. Cells that run side by side send theirs from several threads.
pub trait Progress: Sync {
    /// Something other than a cell takes time; `words` says what.
    fn say(&self, words: &str);
    /// A cell has begun.
    fn on_begun(&self, cell: &Cell);
    /// A cell that had begun is no longer waited for, whether it ended or an error came first.
    fn on_left(&self, cell: &Cell);
    /// A cell has ended; if it is not complete, `reason` says why.
    fn on_ended(&self, cell: &Cell, verdict: Verdict, reason: &str);
}

/// A cell in progress. Reports that it has begun and, when dropped, that it is no longer waited for.
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
