//! A campaign as a row for each cell: what a table and a judgement need, in some two kilobytes a cell.
//!
//! A manifest and the metrics take ten times as much, so the largest plans are read in this way. Figures and the page
//! need a whole [`Campaign`].

use std::path::Path;

use plan::{Plan, Verdict};
use record::Damage;

use crate::campaign::{Campaign, Run};
use crate::summary::Summary;
use crate::unjudged::{self, Unjudged};

/// A cell in its row.
#[derive(Debug, Clone)]
pub struct Outlined {
    /// The cell's index in its plan.
    pub index: usize,
    /// The row.
    pub summary: Summary,
    /// What could not be judged of it.
    pub unjudged: Unjudged,
    /// Every file that is not as the manifest or the plan requires; empty if the folder is whole.
    pub damage: Vec<Damage>,
}

impl Outlined {
    /// The row of a run.
    #[must_use]
    pub fn of(run: Run) -> Outlined {
        Outlined {
            index: run.cell.index,
            unjudged: unjudged::of(&run),
            summary: run.summary,
            damage: run.damage,
        }
    }

    /// How it ended; `None` if it has no manifest.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.summary.verdict
    }

    /// Whether it has not been run in this folder.
    #[must_use]
    pub fn is_absent(&self) -> bool {
        self.summary.verdict.is_none() && self.damage.is_empty()
    }
}

/// Reads the cells of a plan in a folder, in the order of the plan. `on_read` is called after each, from many threads.
pub fn read(folder: &Path, plan: &Plan, on_read: impl Fn() + Sync) -> Vec<Outlined> {
    Campaign::each_row(folder, plan, |run| {
        let row = Outlined::of(run);
        on_read();
        row
    })
}

/// The rows of a campaign that has been read.
#[must_use]
pub fn of(campaign: &Campaign) -> Vec<Outlined> {
    let row = |run: &Run| Outlined {
        index: run.cell.index,
        unjudged: unjudged::of(run),
        summary: run.summary.clone(),
        damage: run.damage.clone(),
    };
    campaign.runs.iter().map(row).collect()
}
