//! A campaign as text: the rows that are shown, as a table and as CSV, and the check whether they
//! may be shown.

use analysis::{Campaign, Run, Summary};

use crate::error::Error;

/// The cells of a plan that a results folder has.
#[derive(Debug)]
pub struct Results {
    /// One row for each cell that has been run or was asked for, in the plan's order.
    pub rows: Vec<Summary>,
    /// The campaign's seed.
    seed: u64,
    /// Number of the plan's other cells. They have not been run here, which is no failure.
    absent: usize,
}

impl Results {
    /// Collects the rows of a campaign. Cells that `asked` selects get a row even if they have not
    /// been run.
    ///
    /// # Errors
    /// As [`check_whole`].
    pub fn of(campaign: &Campaign, asked: impl Fn(&Run) -> bool) -> Result<Results, Error> {
        check_whole(campaign)?;
        let rows: Vec<Summary> = campaign
            .runs
            .iter()
            .filter(|run| run.manifest.is_some() || asked(run))
            .map(|run| run.summary.clone())
            .collect();
        let absent = campaign.runs.len() - rows.len();
        Ok(Results {
            rows,
            seed: campaign.plan.seed,
            absent,
        })
    }

    /// The table of the cells and, if some were repeated, the table of their medians: over complete
    /// runs, and over disturbed ones too if `with_disturbed`.
    #[must_use]
    pub fn table(&self, with_disturbed: bool) -> String {
        let mut table = analysis::table::render(&self.rows, self.seed);
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
    #[must_use]
    pub fn csv(&self) -> String {
        Summary::to_csv(&self.rows)
    }
}

/// Checks that a campaign's folder is whole.
///
/// # Errors
/// [`Error::NotWhole`] when a file is damaged: then no figure of the folder can be trusted.
pub fn check_whole(campaign: &Campaign) -> Result<(), Error> {
    let damage = campaign.damage();
    if damage.is_empty() {
        return Ok(());
    }
    Err(Error::NotWhole {
        folder: campaign.folder.clone(),
        damage,
    })
}
