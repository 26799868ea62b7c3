//! The whole report as one value. Its files are made in [`files`](crate::files).

use analysis::{Campaign, Damage, ReadError};

use crate::claim::{self, Finding};
use crate::figure::{self, Figure};
use crate::table::{self, Table};

/// A report.
#[derive(Debug, Clone)]
pub struct Report<'a> {
    /// The campaign that it is about.
    pub campaign: &'a Campaign,
    /// The paper's claims, and readings of them.
    pub claims: Vec<Finding>,
    /// The paper's tables.
    pub tables: Vec<Table>,
    /// The paper's figures.
    pub figures: Vec<Figure>,
    /// Damaged files.
    pub damage: Vec<Damage>,
}

impl<'a> Report<'a> {
    /// Computes the whole report.
    ///
    /// # Errors
    /// [`ReadError`] if rows that were whole a moment ago cannot be read.
    pub fn of(campaign: &'a Campaign) -> Result<Report<'a>, ReadError> {
        Ok(Report {
            campaign,
            claims: claim::all(campaign)?,
            tables: table::all(campaign)?,
            figures: figure::all(campaign)?,
            damage: campaign.damage(),
        })
    }

    /// The claims themselves, without their readings.
    pub fn strict(&self) -> impl Iterator<Item = &Finding> {
        self.claims
            .iter()
            .filter(|finding| finding.reading_of.is_none())
    }
}
