//! All of a report as one value, and the files that are made of it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use analysis::{Campaign, Damage, ReadError};

use crate::claim::{self, Finding};
use crate::digest;
use crate::figure::{self, Figure};
use crate::junit;
use crate::page;
use crate::table::{self, Table};

/// A report.
#[derive(Debug, Clone)]
pub struct Report<'a> {
    /// What it is of.
    pub campaign: &'a Campaign,
    /// The paper's claims, and readings of them.
    pub claims: Vec<Finding>,
    /// The paper's tables.
    pub tables: Vec<Table>,
    /// The paper's figures.
    pub figures: Vec<Figure>,
    /// Files that are not what they have to be.
    pub damage: Vec<Damage>,
}

impl<'a> Report<'a> {
    /// Works everything out.
    ///
    /// # Errors
    /// [`ReadError`] where rows that were whole a moment ago cannot be read.
    pub fn of(campaign: &'a Campaign) -> Result<Report<'a>, ReadError> {
        Ok(Report {
            campaign,
            claims: claim::all(campaign)?,
            tables: table::all(campaign)?,
            figures: figure::all(campaign)?,
            damage: campaign.damage(),
        })
    }

    /// The claims themselves, without readings of them.
    pub fn strict(&self) -> impl Iterator<Item = &Finding> {
        self.claims
            .iter()
            .filter(|finding| finding.reading_of.is_none())
    }

    /// Every file of the report: its name, and what is in it.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let text = |name: &str, content: String| (PathBuf::from(name), content.into_bytes());
        let mut files = vec![
            text("report.html", page::render(self)),
            text("claims.json", claim::to_json(&self.claims)),
            text("claims.csv", claim::to_csv(&self.claims)),
            text("summary.md", digest::markdown(self)),
            text("junit.xml", junit::xml(self)),
        ];
        files.extend(self.tables.iter().flat_map(Table::files));
        files.extend(self.figures.iter().flat_map(Figure::files));
        files
    }
}

/// Writes a report's [files](Report::files) into `folder`, over those of an earlier one.
///
/// # Errors
/// When the folder or a file cannot be written.
pub fn write(files: &[(PathBuf, Vec<u8>)], folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for (name, content) in files {
        // A report lies in a results folder, in which a name may have been made to lead elsewhere.
        file::make_folder(folder, name.parent().unwrap_or(Path::new("")))?;
        file::write(&folder.join(name), content)?;
    }
    Ok(())
}
