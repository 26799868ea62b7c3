//! Reports on standard error what is damaged or missing in a campaign.

use std::path::Path;

use analysis::{Campaign, Run};
use plan::Verdict;

/// Reports which files are damaged, except those of runs that `is_allowed` accepts. Returns how many.
pub(crate) fn tell_damage(campaign: &Campaign, is_allowed: impl Fn(&Run) -> bool) -> usize {
    let runs = campaign.runs.iter().filter(|run| !is_allowed(run));
    let mut count = 0;
    for one in runs.flat_map(|run| &run.damage) {
        say!("webloop: {one}");
        count += 1;
    }
    count
}

/// Reports which undamaged runs are missing or not complete, except those that `is_allowed` accepts. Returns how
/// many.
pub(crate) fn tell_missing(
    campaign: &Campaign,
    name: &Path,
    is_allowed: impl Fn(&Run) -> bool,
) -> usize {
    let undamaged = campaign.runs.iter().filter(|run| run.damage.is_empty());
    let missing = undamaged.filter(|run| run.verdict() != Some(Verdict::Complete));
    let mut count = 0;
    for run in missing.filter(|run| !is_allowed(run)) {
        let id = &run.cell.id;
        let name = name.display();
        match run.verdict() {
            None => say!("webloop: {name}: {id} has not been run"),
            Some(verdict) => say!("webloop: {name}: {id} is {verdict}"),
        }
        count += 1;
    }
    count
}

/// Whether both campaigns are whole, as they have to be for a check to pass, but for runs that `is_allowed`
/// accepts. Reports on standard error what is not.
pub(crate) fn are_whole(
    both: [(&Campaign, &Path); 2],
    allow_missing: bool,
    is_allowed: impl Fn(&Run) -> bool,
) -> bool {
    let (mut damaged, mut missing) = (0, 0);
    for (campaign, name) in both {
        damaged += tell_damage(campaign, &is_allowed);
        if !allow_missing {
            missing += tell_missing(campaign, name, &is_allowed);
        }
    }
    if missing > 0 {
        say!("webloop: the missing runs were not compared; --allow-missing accepts that");
    }
    damaged + missing == 0
}
