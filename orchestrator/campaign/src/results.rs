//! A campaign as text: the rows that are shown, the table and the CSV of them; and what keeps it from
//! being shown.

use analysis::{Campaign, Run, Summary};

use crate::error::Error;

/// What is in a results folder, of the cells of its plan.
#[derive(Debug)]
pub struct Results {
    /// One row for each cell that has been run or was asked for, in the plan's order.
    pub rows: Vec<Summary>,
    /// How many cells the plan has besides: nobody has run them here, which is no failure.
    absent: usize,
}

impl Results {
    /// Of a campaign; `asked` cells get a row even if they have not been run.
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
        Ok(Results { rows, absent })
    }

    /// The table of the cells and, where some were repeated, that of their medians: of complete runs, and
    /// of disturbed ones too where that is asked for.
    #[must_use]
    pub fn table(&self, with_disturbed: bool) -> String {
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
    #[must_use]
    pub fn csv(&self) -> String {
        Summary::to_csv(&self.rows)
    }
}

/// Whether a campaign's folder is whole.
///
/// # Errors
/// [`Error::NotWhole`] where a file is damaged: no figure of the folder is to be believed then.
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
