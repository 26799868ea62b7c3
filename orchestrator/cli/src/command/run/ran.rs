//! Cells that were run: what is in their folder, and what exit code they come to.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use analysis::Campaign;
use analysis::campaign::Fresh;
use analysis::outline::{self, Outlined};
use campaign::CampaignFolder;
use plan::{Cell, Plan, Verdict};

use crate::argument::Progress as How;
use crate::exit::{Exit, Failure};

/// Most cells of which a page is made by itself: each takes some 30 kB of memory, and its own place on the page.
pub(super) const PAGE_CELLS: usize = 5_000;

/// Most cells that are read after an interruption, which takes half a second.
const AT_ONCE_CELLS: usize = 500;

/// Cells that were run, and their folder.
pub(crate) struct Ran<'a> {
    pub(super) plan: &'a Plan,
    pub(super) chosen: &'a [&'a Cell],
    pub(super) folder: CampaignFolder,
    pub(super) is_interrupted: bool,
    pub(super) progress: How,
    /// What is known of the rows of cells in virtual time.
    pub(super) fresh: Fresh,
}

/// What is in a campaign's folder after its cells were run.
pub(crate) struct Read {
    /// All of it; `None` of more cells than a page is made of.
    pub(crate) campaign: Option<Campaign>,
    /// A row for each cell.
    pub(crate) rows: Vec<Outlined>,
}

impl Ran<'_> {
    /// Reads the folder: whole, or only in rows where it has more cells than a page is made of.
    pub(crate) fn read(&self) -> Result<Read, Failure> {
        let folder = self.folder.path();
        let all = self.plan.cells.len();
        if all <= PAGE_CELLS {
            let campaign = Campaign::read_after(folder, &self.fresh)?;
            let rows = outline::of(&campaign);
            let campaign = Some(campaign);
            return Ok(Read { campaign, rows });
        }
        let done = AtomicUsize::new(0);
        let rows = outline::read(folder, self.plan, || {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if done.is_multiple_of(PAGE_CELLS) && self.progress != How::Quiet {
                say!("[{done}/{all}] read");
            }
        });
        let campaign = None;
        Ok(Read { campaign, rows })
    }

    /// The rows of the chosen cells.
    pub(crate) fn asked<'a>(&self, rows: &'a [Outlined]) -> Vec<&'a Outlined> {
        let asked = self.indices();
        let is_asked = |row: &&Outlined| asked.contains(&row.index);
        rows.iter().filter(is_asked).collect()
    }

    pub(super) fn indices(&self) -> BTreeSet<usize> {
        self.chosen.iter().map(|cell| cell.index).collect()
    }

    /// The exit code of the runs alone.
    pub(crate) fn exit(&self, asked: &[&Outlined]) -> Exit {
        exit(asked.iter().map(|row| row.verdict()), self.is_interrupted)
    }

    /// Whether it was interrupted with so many cells that reading them takes longer than whoever interrupts waits.
    pub(crate) fn ends_at_once(&self) -> bool {
        self.is_interrupted && self.chosen.len() > AT_ONCE_CELLS
    }
}

/// The exit code of the worst verdict. A cell without a verdict left no manifest, so it failed.
pub(crate) fn exit(verdicts: impl Iterator<Item = Option<Verdict>>, interrupted: bool) -> Exit {
    if interrupted {
        return Exit::Interrupted;
    }
    match verdicts
        .map(|verdict| verdict.unwrap_or(Verdict::Failed))
        .max()
    {
        Some(Verdict::Complete) | None => Exit::Fine,
        Some(Verdict::Unsupported) => Exit::Unsupported,
        Some(_) => Exit::Failed,
    }
}
