//! The rows of a run in memory, just as they are in its files: of one in virtual time, which made them, or read once
//! for all who ask.

use std::collections::BTreeMap;
use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use plan::{ProbeRow, file_name};
use text::column::Row;

use crate::fact::FileFact;
use crate::rows::{ReadError, read};

/// All rows of a run, and what its files of rows are known by.
#[derive(Debug, Clone, Default)]
pub struct Held {
    /// Rows of `ticks.csv`.
    pub ticks: Vec<TickRow>,
    /// Rows of `second.csv`; `None` if there is no second input or output.
    pub second: Option<Vec<SecondRow>>,
    /// Rows of `arrivals.csv`.
    pub arrivals: Vec<ArrivalRow>,
    /// Rows of `messages.csv`.
    pub messages: Vec<MessageRow>,
    /// Rows of `probes.csv`.
    pub probes: Vec<ProbeRow>,
    /// Length and checksum of each file that was counted while it was written, by name.
    pub files: BTreeMap<String, FileFact>,
}

impl Held {
    /// The rows of both ends in a cell's folder, those of their second signals left out.
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn read(folder: &Path) -> Result<Held, ReadError> {
        Ok(Held {
            messages: of(&folder.join(file_name::MESSAGES))?,
            arrivals: of(&folder.join(file_name::ARRIVALS))?,
            ticks: of(&folder.join(file_name::TICKS))?,
            ..Held::default()
        })
    }
}

fn of<R: Row + Copy>(path: &Path) -> Result<Vec<R>, ReadError> {
    let mut rows = Vec::new();
    read(path, |row| rows.push(*row))?;
    Ok(rows)
}
