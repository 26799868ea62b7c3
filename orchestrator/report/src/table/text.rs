//! A table for people at a terminal: aligned, with the names of groups over those of columns.

use analysis::layout::{Column, align};
use text::significant;

use super::{Entry, Table};

impl Table {
    /// The table as text: title, two lines of heading, the rows, the notes. Text is left-aligned,
    /// numbers are right-aligned, and `-` is an empty entry.
    #[must_use]
    pub fn to_text(&self) -> String {
        let columns: Vec<Column> = (self.columns.iter().enumerate())
            .map(|(at, column)| Column {
                number: self.is_number(at),
                ..*column
            })
            .collect();
        let words = |row: &Vec<Entry>| row.iter().map(Entry::words).collect();
        let rows: Vec<Vec<String>> = self.rows.iter().map(words).collect();
        let mut out = format!("{}\n\n{}", self.title, align(&columns, &rows));
        if !self.notes.is_empty() {
            out += &format!("\n{}\n", self.notes.join("\n"));
        }
        out
    }
}

impl Entry {
    /// The entry as it is printed.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Entry::Text(words) => words.clone(),
            Entry::Number(number, digits) => significant(*number, *digits),
            Entry::None => "-".to_owned(),
        }
    }
}
