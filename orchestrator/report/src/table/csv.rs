//! A table as CSV, for programs.

use analysis::layout::Column;

use super::{Entry, Table};

impl Table {
    /// The table as CSV (RFC 4180, but lines end in a newline alone): a line of column names, each
    /// after the name of its group, and a line for each row. Numbers are in the shortest form that
    /// loses nothing; an unknown one is empty. Title and notes are left out.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let names = self.columns.iter().map(name).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(entry).collect());
        let lines = std::iter::once(names).chain(rows);
        lines
            .map(|line: Vec<String>| line.join(",") + "\n")
            .collect()
    }
}

fn name(column: &Column) -> String {
    quoted(if column.group.is_empty() {
        column.name.to_owned()
    } else {
        format!("{} {}", column.group, column.name)
    })
}

fn entry(entry: &Entry) -> String {
    match entry {
        Entry::Text(words) => quoted(words.clone()),
        Entry::Number(number, _) => number.to_string(),
        Entry::None => String::new(),
    }
}

fn quoted(field: String) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field
    }
}
