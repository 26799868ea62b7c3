//! A campaign as text: the rows that are shown, the table and the CSV of them.

use analysis::{Campaign, Run, Summary};
use anyhow::anyhow;

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
    /// When a manifest or a row file is damaged; names file and line.
    pub(crate) fn of(campaign: &Campaign, asked: impl Fn(&Run) -> bool) -> anyhow::Result<Results> {
        if let Some(problem) = campaign.runs.iter().find_map(|run| run.problem.as_ref()) {
            return Err(anyhow!("{problem}"));
        }
        let rows: Vec<Summary> = campaign
            .runs
            .iter()
            .filter(|run| run.manifest.is_some() || asked(run))
            .map(|run| run.summary.clone())
            .collect();
        let absent = campaign.runs.len() - rows.len();
        Ok(Results { rows, absent })
    }

    /// The table of the cells and, where some were repeated, that of their medians.
    pub(crate) fn table(&self) -> String {
        let mut table = analysis::table::render(&self.rows);
        if let Some(medians) = analysis::repeats::render(&self.rows) {
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
