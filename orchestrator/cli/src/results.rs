//! Reports on standard error what is damaged or missing in a campaign.

use std::path::Path;

use analysis::Campaign;
use plan::Verdict;

/// Reports which files are damaged. Returns how many.
pub(crate) fn tell_damage(campaign: &Campaign) -> usize {
    let damage = campaign.damage();
    for one in &damage {
        eprintln!("webloop: {one}");
    }
    damage.len()
}

/// Reports which undamaged runs are missing or not complete. Returns how many.
pub(crate) fn tell_missing(campaign: &Campaign, name: &Path) -> usize {
    let undamaged = campaign.runs.iter().filter(|run| run.damage.is_empty());
    let missing = undamaged.filter(|run| run.verdict() != Some(Verdict::Complete));
    let mut count = 0;
    for run in missing {
        let id = &run.cell.id;
        let name = name.display();
        match run.verdict() {
            None => eprintln!("webloop: {name}: {id} has not been run"),
            Some(verdict) => eprintln!("webloop: {name}: {id} is {verdict}"),
        }
        count += 1;
    }
    count
}

/// Whether both campaigns are whole, as they have to be for a check to pass. Reports on standard
/// error what is not.
pub(crate) fn are_whole(both: [(&Campaign, &Path); 2], allow_missing: bool) -> bool {
    let (mut damaged, mut missing) = (0, 0);
    for (campaign, name) in both {
        damaged += tell_damage(campaign);
        if !allow_missing {
            missing += tell_missing(campaign, name);
        }
    }
    if missing > 0 {
        eprintln!("webloop: the missing runs were not compared; --allow-missing accepts that");
    }
    damaged + missing == 0
}
