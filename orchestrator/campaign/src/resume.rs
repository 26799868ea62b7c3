//! Finds the cells that are still to run when a folder is continued.

use std::collections::BTreeMap;
use std::path::PathBuf;

use analysis::{Campaign, Run};
use plan::{Cell, Plan, Verdict, file_name};
use record::{Damage, folder};

use crate::campaign_folder::CampaignFolder;
use crate::earlier::Own;
use crate::error::Error;

/// What is asked of an earlier run: the largest plans have a hundred thousand, so no more of each is kept.
struct Earlier {
    id: String,
    verdict: Option<Verdict>,
    folder: PathBuf,
    damage: Vec<Damage>,
    /// Whether this run would have made it in the same way.
    own: Result<(), Error>,
}

impl Earlier {
    fn of(run: Run, plan: &Plan, own: &Own) -> Earlier {
        let manifest = run.manifest.as_ref();
        let own = manifest.map_or(Ok(()), |manifest| own.check(plan, manifest, &run.folder));
        Earlier {
            verdict: run.verdict(),
            id: run.cell.id,
            folder: run.folder,
            damage: run.damage,
            own,
        }
    }
}

/// Those of the chosen cells of a plan that are to be run: all that are not complete, or with `failed` only
/// those that were run without becoming complete or are damaged. Damaged runs are moved aside.
///
/// # Errors
/// When the folder's runs are not of this run's kind, or a damaged one would stay in the folder.
pub fn pending<'a>(
    plan: &Plan,
    chosen: &[&'a Cell],
    campaign: &CampaignFolder,
    own: &Own,
    failed: bool,
) -> Result<Vec<&'a Cell>, Error> {
    let cells = campaign.path().join(file_name::CELLS);
    if cells.symlink_metadata().is_err() && !failed {
        // A new folder.
        return Ok(chosen.to_vec());
    }
    let mut runs = Campaign::each_run(campaign.path(), plan, |run| Earlier::of(run, plan, own));
    for run in &mut runs {
        std::mem::replace(&mut run.own, Ok(()))?;
    }
    let chosen: BTreeMap<&str, &'a Cell> = chosen.iter().map(|cell| (&*cell.id, *cell)).collect();
    let (mut pending, mut stays_damaged) = (Vec::new(), false);
    for run in &runs {
        let cell = chosen.get(&*run.id).copied();
        let is_whole = run.damage.is_empty();
        let is_due = match run.verdict {
            Some(Verdict::Complete) => failed && !is_whole,
            Some(_) => true,
            None if is_whole => !failed,
            None => failed,
        };
        match cell {
            Some(cell) if is_due => pending.push(cell),
            _ if is_whole => {}
            _ => stays_damaged = true,
        }
    }
    if stays_damaged {
        let damage = runs.into_iter().flat_map(|run| run.damage);
        return Err(Error::NotWhole {
            folder: campaign.path().to_owned(),
            damage: damage.collect(),
        });
    }
    for run in runs.iter().filter(|run| !run.damage.is_empty()) {
        folder::move_aside(&run.folder)?;
    }
    Ok(pending)
}
