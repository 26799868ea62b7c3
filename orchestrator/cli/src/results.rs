//! Reads a campaign and judges its runs again, and reports on standard error what is damaged or missing in it.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use analysis::{Campaign, Run};
use plan::{Plan, Verdict};

use backend::Again;

use crate::exit::Failure;

/// Reads a results folder. A run that its manifest calls complete is judged again by its rows; where that disagrees, it
/// has the new verdict, with its reasons, and that is said.
///
/// # Errors
/// When it is not a results folder.
pub(crate) fn read(folder: &Path) -> Result<Campaign, Failure> {
    let plan = Campaign::plan(folder).map_err(Failure::usage)?;
    let again = JudgeAgain::new(&plan, folder);
    let runs = Campaign::each_run(folder, &plan, |run| again.judge(run));
    again.tell_others();
    let folder = folder.to_owned();
    Ok(Campaign { folder, plan, runs })
}

/// Judges the runs of a folder again by their rows, from many threads.
pub(crate) struct JudgeAgain<'a> {
    plan: &'a Plan,
    folder: &'a Path,
    /// Runs whose link another version of webloop played.
    others: AtomicUsize,
}

impl<'a> JudgeAgain<'a> {
    pub(crate) fn new(plan: &'a Plan, folder: &'a Path) -> Self {
        let others = AtomicUsize::new(0);
        Self {
            plan,
            folder,
            others,
        }
    }

    /// The run with the verdict of its rows, if its manifest calls it complete and they disagree, which is said.
    pub(crate) fn judge(&self, mut run: Run) -> Run {
        let Some(manifest) = run.manifest.as_ref().filter(|_| run.is_complete()) else {
            return run;
        };
        let again = backend::judge_again(self.plan, &run.cell, &run.folder, manifest);
        let (verdict, reasons) = match again {
            Ok(Again::Judged(verdict, reasons)) if verdict != Verdict::Complete => {
                (verdict, reasons)
            }
            Err(problem) => (Verdict::Invalid, vec![problem.to_string()]),
            Ok(Again::OtherLink) => {
                self.others.fetch_add(1, Ordering::Relaxed);
                return run;
            }
            Ok(Again::Judged(..) | Again::Unjudged) => return run,
        };
        say!(
            "webloop: {}: {} is called complete, and its rows say {verdict}: {}",
            self.folder.display(),
            run.cell.id,
            reasons.join("; ")
        );
        run.judged_again(verdict, reasons);
        run
    }

    /// Says how many runs could not be judged again.
    pub(crate) fn tell_others(&self) {
        let others = self.others.load(Ordering::Relaxed);
        if others > 0 {
            say!(
                "webloop: {}: {others} of the runs cannot be judged again by their rows: another version of webloop predicted \
                 their echoes; their verdicts are that version's",
                self.folder.display()
            );
        }
    }
}

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
