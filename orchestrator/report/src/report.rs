//! The whole report as one value. Its files are made in [`files`](crate::files).

use analysis::Campaign;
use analysis::expect::Judgement;
use record::{Damage, ReadError};

use crate::brief::{self, Brief};
use crate::claim::Finding;
use crate::delays::{self, Nearest};
use crate::figure::{self, Figure};
use crate::table::{Table, cost, delay, fault};

/// What a publication adds to the report on the experiment that repeats it.
#[derive(Debug, Clone, Default)]
pub struct Exhibits {
    /// Its claims, and readings of them, with the verdicts of the runs.
    pub claims: Vec<Finding>,
    /// Its tables.
    pub tables: Vec<Table>,
    /// Its figures.
    pub figures: Vec<Figure>,
    /// Whether the campaign is the publication's own experiment: its figures then stand in place of the
    /// general ones.
    pub is_own: bool,
}

/// A report.
#[derive(Debug, Clone)]
pub struct Report<'a> {
    /// The campaign that it is about.
    pub campaign: &'a Campaign,
    /// The questions with their answers.
    pub brief: Vec<Brief>,
    /// The paper's claims, and readings of them.
    pub claims: Vec<Finding>,
    /// The tables.
    pub tables: Vec<Table>,
    /// The figures: those of any experiment, then the paper's.
    pub figures: Vec<Figure>,
    /// Damaged files.
    pub damage: Vec<Damage>,
    /// What became of what is expected of the runs; empty if nothing is.
    pub expectations: Judgement,
}

impl<'a> Report<'a> {
    /// Computes the whole report; `exhibits` are added to it.
    ///
    /// # Errors
    /// [`ReadError`] if rows that were whole a moment ago cannot be read.
    pub fn of(campaign: &'a Campaign, exhibits: Exhibits) -> Result<Report<'a>, ReadError> {
        let delays = delays::all(campaign)?;
        let nearest = Nearest::of(campaign, &delays);
        let mut figures = if exhibits.is_own {
            Vec::new()
        } else {
            figure::all(campaign, &delays, nearest.as_ref())?
        };
        figures.extend(exhibits.figures);
        figure::annotate(&mut figures, campaign);
        let mut tables = Vec::new();
        if !exhibits.is_own {
            tables.extend(cost::table(campaign, &delays));
            tables.extend(delay::table(&delays));
            tables.extend(fault::table(campaign));
        }
        tables.extend(exhibits.tables);
        if campaign.is_simulated() {
            for table in &mut tables {
                table.title += ", simulated";
            }
        }
        Ok(Report {
            campaign,
            brief: brief::all_of(campaign, &delays, nearest.as_ref()),
            claims: exhibits.claims,
            tables,
            figures,
            damage: campaign.damage(),
            expectations: Judgement::default(),
        })
    }

    /// The report with what became of the expectations, which depends on the day.
    #[must_use]
    pub fn with_expectations(self, expectations: Judgement) -> Report<'a> {
        Report {
            expectations,
            ..self
        }
    }

    /// The claims themselves, without their readings.
    pub fn strict(&self) -> impl Iterator<Item = &Finding> {
        self.claims
            .iter()
            .filter(|finding| finding.reading_of.is_none())
    }
}
