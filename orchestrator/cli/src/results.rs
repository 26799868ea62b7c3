//! What is damaged or missing of a campaign, said on standard error.

use std::path::Path;

use analysis::Campaign;
use plan::Verdict;

/// Says which files are damaged; how many.
pub(crate) fn tell_damage(campaign: &Campaign) -> usize {
    let damage = campaign.damage();
    for one in &damage {
        eprintln!("webloop: {one}");
    }
    damage.len()
}

/// Says which runs are missing or not complete; how many.
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

/// Whether both of two campaigns are all that they were to be, as a check that passes has to know.
/// What is not is said on standard error.
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
