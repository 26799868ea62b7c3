//! What is left to do in a folder that is gone on with.

use std::collections::BTreeMap;

use analysis::Campaign;
use plan::{Cell, Verdict};

use crate::campaign_folder::CampaignFolder;
use crate::earlier::Own;
use crate::error::Error;
use crate::results::check_whole;

/// Those of the cells that are to be run: what is complete is left alone, and of the others only
/// what was run and `failed`, or is damaged, if that is asked for. What is damaged is moved aside
/// then.
///
/// # Errors
/// Where the folder's runs are not of this run's kind; where one that would be left alone is damaged.
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
