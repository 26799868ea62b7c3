//! The paper's tables, recomputed, with the paper's numbers beside ours.

use analysis::{Campaign, ReadError};
use serde::Serialize;

/// A table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// What its files are called: `table-2`.
    pub name: String,
    /// Its number in the paper and its heading: `Table 2: round trips`.
    pub title: String,
    /// What has to be known to read it: units, runs, seed, back-end, player.
    pub notes: Vec<String>,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Its rows, an entry for each column.
    pub rows: Vec<Vec<Entry>>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its name with its unit: `avg/ms`.
    pub name: String,
    /// What its neighbours have in common: `the paper`, `here`.
    pub group: String,
}

/// What stands in a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Entry {
    /// Words.
    Text(String),
    /// A number, and with how many significant digits it is printed; the CSV has all of it.
    Number(f64, u8),
    /// Nothing to say: not run, or the paper has none.
    None,
}

/// Every table, in the paper's order.
///
/// # Errors
/// [`ReadError`] where rows that a table needs cannot be read.
pub fn all(_campaign: &Campaign) -> Result<Vec<Table>, ReadError> {
    Ok(Vec::new())
}
