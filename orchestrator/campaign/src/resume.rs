//! Finds the cells that are still to run when a folder is continued.

use std::collections::BTreeMap;

use analysis::Campaign;
use plan::{Cell, Verdict};

use crate::campaign_folder::CampaignFolder;
use crate::earlier::Own;
use crate::error::Error;
use crate::results::check_whole;

/// Those of the chosen cells that are to be run: all that are not complete, or with `failed` only
/// those that were run without becoming complete or are damaged. Damaged runs are moved aside.
///
/// # Errors
/// When the folder's runs are not of this run's kind, or a damaged one would stay in the folder.
pub fn pending<'a>(
    chosen: &[&'a Cell],
    campaign: &CampaignFolder,
    own: &Own,
    failed: bool,
) -> Result<Vec<&'a Cell>, Error> {
    let read = Campaign::read(campaign.path())?;
    for run in &read.runs {
        if let Some(manifest) = &run.manifest {
            own.check(&read.plan, manifest, &run.folder)?;
        }
    }
    let chosen: BTreeMap<&str, &'a Cell> = chosen.iter().map(|cell| (&*cell.id, *cell)).collect();
    let (mut pending, mut damaged) = (Vec::new(), Vec::new());
    for run in &read.runs {
        let cell = chosen.get(&*run.cell.id).copied();
        let is_whole = run.damage.is_empty();
        let is_due = match run.verdict() {
            Some(Verdict::Complete) => failed && !is_whole,
            Some(_) => true,
            None if is_whole => !failed,
            None => failed,
        };
        match cell {
            Some(cell) if is_due => pending.push(cell),
            _ if is_whole => {}
            _ => damaged.push(run),
        }
    }
    if !damaged.is_empty() {
        check_whole(&read)?;
    }
    for run in read.runs.iter().filter(|run| !run.damage.is_empty()) {
        backend::move_aside(&run.folder)?;
    }
    Ok(pending)
}
