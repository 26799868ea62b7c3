//! A campaign as text: the rows that are shown, the table and the CSV of them; and what keeps it from
//! being shown.

use std::path::Path;

use analysis::{Campaign, Run, Summary};
use anyhow::anyhow;
use plan::Verdict;

/// What is in a results folder, of the cells of its plan.
pub(crate) struct Results {
    /// One row for each cell that has been run or was asked for, in the plan's order.
    pub(crate) rows: Vec<Summary>,
    /// How many cells the plan has besides: nobody has run them here, which is no failure.
    absent: usize,
}

impl Results {
    /// Of a campaign; `asked` cells get a row even if they have not been run.
    ///
    /// # Errors
    /// As [`believed`].
    pub(crate) fn of(campaign: &Campaign, asked: impl Fn(&Run) -> bool) -> anyhow::Result<Results> {
        believed(campaign)?;
        let rows: Vec<Summary> = campaign
            .runs
            .iter()
            .filter(|run| run.manifest.is_some() || asked(run))
            .map(|run| run.summary.clone())
            .collect();
        let absent = campaign.runs.len() - rows.len();
        Ok(Results { rows, absent })
    }

    /// The table of the cells and, where some were repeated, that of their medians: of complete runs, and
    /// of disturbed ones too where that is asked for.
    pub(crate) fn table(&self, with_disturbed: bool) -> String {
        let mut table = analysis::table::render(&self.rows);
        if let Some(medians) = analysis::repeats::render(&self.rows, with_disturbed) {
            table += &format!("\n{medians}");
        }
        if self.absent > 0 {
            let all = self.rows.len() + self.absent;
            table += &format!(
                "\n{} of the plan's {all} cells have not been run here.\n",
                self.absent
            );
        }
        table
    }

    /// Every figure of the table and more, for programs.
    pub(crate) fn csv(&self) -> String {
        Summary::to_csv(&self.rows)
    }
}

/// Whether a campaign's folder is whole; what is not is said on standard error, a line each.
///
/// # Errors
/// Where a file is damaged: no figure of the folder is to be believed then.
pub(crate) fn believed(campaign: &Campaign) -> anyhow::Result<()> {
    match tell_damage(campaign) {
        0 => Ok(()),
        count => Err(anyhow!(
            "{} is not whole: {count} of its files are not what they have to be; restore them, or make \
             their cells again with `webloop run .. --out {} --failed`",
            campaign.folder.display(),
            campaign.folder.display()
        )),
    }
}

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
        eprintln!("webloop: what is missing was not looked at; --allow-missing lets it be so");
    }
    damaged + missing == 0
}
