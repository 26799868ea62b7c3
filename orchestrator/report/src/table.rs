//! A table as a value; [`Table::to_csv`] is for programs, [`Table::to_text`] for people.

pub mod cost;
mod csv;
pub mod delay;
pub mod fault;
mod text;

use std::path::PathBuf;

use analysis::layout::Column;

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of its files: `table-2`.
    pub name: String,
    /// Its number in the paper and its heading: `Table 2: round trips`.
    pub title: String,
    /// What a reader has to know: units, runs, seed, back-end, player.
    pub notes: Vec<String>,
    /// Its columns. Whether a column is numeric follows from the rows.
    pub columns: Vec<Column>,
    /// Its rows, with an entry for each column.
    pub rows: Vec<Vec<Entry>>,
}

/// An entry of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// A text.
    Text(String),
    /// A number, and the significant digits with which it is printed; the CSV has all digits.
    Number(f64, u8),
    /// Empty: not run, or the paper has no number.
    None,
}

impl Table {
    /// The same table without columns that are empty in all rows.
    #[must_use]
    pub fn filled(mut self) -> Table {
        let is_filled: Vec<bool> = (0..self.columns.len())
            .map(|at| {
                let mut entries = self.rows.iter().filter_map(|row| row.get(at));
                entries.any(|entry| *entry != Entry::None)
            })
            .collect();
        let mut of_columns = is_filled.iter();
        self.columns.retain(|_| of_columns.next() == Some(&true));
        for row in &mut self.rows {
            let mut of_entries = is_filled.iter();
            row.retain(|_| of_entries.next() == Some(&true));
        }
        self
    }

    /// Its files in a report's folder: `tables/table-2.csv` and `.txt`.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let path = |ending: &str| PathBuf::from(format!("tables/{}.{ending}", self.name));
        vec![
            (path("csv"), self.to_csv().into_bytes()),
            (path("txt"), self.to_text().into_bytes()),
        ]
    }

    /// Whether a column has numbers, which are right-aligned with their heading.
    pub(crate) fn is_number(&self, at: usize) -> bool {
        let mut entries = self.rows.iter().filter_map(|row| row.get(at));
        entries.any(|entry| matches!(entry, Entry::Number(..)))
    }
}

impl Entry {
    /// A text.
    #[must_use]
    pub fn text(words: impl Into<String>) -> Entry {
        Entry::Text(words.into())
    }

    /// A measured number to this many significant digits; empty if there is none.
    #[must_use]
    pub fn measured(number: Option<f64>, digits: u8) -> Entry {
        number.map_or(Entry::None, |number| Entry::Number(number, digits))
    }

    /// A number with all of its digits, as the paper prints it.
    #[must_use]
    pub fn printed(number: f64) -> Entry {
        let text = number.abs().to_string();
        let significant = text.trim_start_matches(['0', '.']).replace('.', "");
        Entry::Number(
            number,
            u8::try_from(significant.len().max(1)).unwrap_or(u8::MAX),
        )
    }

    /// A whole number.
    #[must_use]
    pub fn count(count: u64) -> Entry {
        Entry::printed(count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::Entry;

    #[test]
    fn a_printed_number_keeps_its_digits() {
        for number in [0.0, 0.031, 3.376, 13.42, 3033.374, 1200.0, 0.9] {
            assert_eq!(Entry::printed(number).words(), number.to_string());
        }
        assert_eq!(Entry::count(20).words(), "20");
    }
}
