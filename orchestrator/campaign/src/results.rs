//! A campaign as text: the rows that are shown, as a table and as CSV, and the check whether they
//! may be shown.

use std::collections::BTreeSet;
use std::path::Path;

use analysis::layout::wrapped;
use analysis::outline::{self, Outlined};
use analysis::repeats::{self, Over};
use analysis::unjudged;
use analysis::{Campaign, Run, Summary};
use record::Damage;

use crate::error::Error;

/// Rows that make one part of the CSV.
const PART: usize = 2_000;

/// The cells of a plan that a results folder has.
#[derive(Debug)]
pub struct Results {
    /// One row for each cell that has been run or was asked for, in the plan's order.
    pub rows: Vec<Summary>,
    /// The campaign's seed.
    seed: u64,
    /// What could not be judged of them, in a sentence.
    unjudged: Option<String>,
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
        let asked: BTreeSet<usize> = campaign
            .runs
            .iter()
            .filter(|run| asked(run))
            .map(|run| run.cell.index)
            .collect();
        let rows = outline::of(campaign);
        let is_asked = |row: &Outlined| asked.contains(&row.index);
        Results::of_rows(rows, (&campaign.folder, campaign.plan.seed), is_asked)
    }

    /// Collects the rows of the cells of a plan's folder, which has this path, and the plan this seed. Cells that
    /// `asked` selects get a row even if they have not been run.
    ///
    /// # Errors
    /// As [`check_whole`].
    pub fn of_rows(
        rows: Vec<Outlined>,
        (folder, seed): (&Path, u64),
        asked: impl Fn(&Outlined) -> bool,
    ) -> Result<Results, Error> {
        check_rows(&rows, folder)?;
        let all = rows.len();
        let unjudged = unjudged::sentence(rows.iter().map(|row| &row.unjudged));
        let rows: Vec<Summary> = rows
            .into_iter()
            .filter(|row| row.verdict().is_some() || asked(row))
            .map(|row| row.summary)
            .collect();
        Ok(Results {
            absent: all - rows.len(),
            seed,
            unjudged,
            rows,
        })
    }

    /// The table of the cells and, if some were repeated, the table of their medians.
    #[must_use]
    pub fn table(&self, medians_over: Over) -> String {
        let mut table = analysis::table::render(&self.rows, self.seed);
        if let Some(medians) = repeats::render(&self.rows, medians_over) {
            table += &format!("\n{medians}");
        }
        if let Some(unjudged) = &self.unjudged {
            table += &format!("\n{}", wrapped(&[unjudged.as_str()]));
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

    /// Every figure of the table and more, for programs: the text of `summary.csv`, in parts of some megabytes.
    pub fn csv(&self) -> impl Iterator<Item = String> + '_ {
        let parts = self.rows.chunks(PART).enumerate();
        let of_none = self.rows.is_empty().then(|| Summary::to_csv(&[]));
        let texts = parts.map(|(at, rows)| match (at, Summary::to_csv(rows)) {
            (0, text) => text,
            // Its header is in the first one.
            (_, text) => text
                .split_once('\n')
                .map_or(String::new(), |(_, rest)| rest.to_owned()),
        });
        of_none.into_iter().chain(texts)
    }

    /// Number of the plan's cells that have not been run here and were not asked for.
    #[must_use]
    pub fn absent(&self) -> usize {
        self.absent
    }
}

/// Checks that the cells of a folder are whole, as [`check_whole`].
///
/// # Errors
/// [`Error::NotWhole`] when a file is damaged.
pub fn check_rows(rows: &[Outlined], folder: &Path) -> Result<(), Error> {
    let damage = rows.iter().flat_map(|row| &row.damage);
    whole(damage.cloned().collect(), folder)
}

fn whole(damage: Vec<Damage>, folder: &Path) -> Result<(), Error> {
    if damage.is_empty() {
        return Ok(());
    }
    Err(Error::NotWhole {
        folder: folder.to_owned(),
        damage,
    })
}

/// Checks that a campaign's folder is whole.
///
/// # Errors
/// [`Error::NotWhole`] when a file is damaged: then no figure of the folder can be trusted.
pub fn check_whole(campaign: &Campaign) -> Result<(), Error> {
    whole(campaign.damage(), &campaign.folder)
}
