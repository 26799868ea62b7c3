//! A table for people at a terminal: aligned, with its groups over its columns' names.

use super::{Entry, Table};
use crate::number::significant;

impl Table {
    /// The table as text: title, two lines of heading, the rows, the notes. Words stand left,
    /// numbers right; `-` is nothing to say.
    #[must_use]
    pub fn to_text(&self) -> String {
        let printed: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(Entry::words).collect())
            .collect();
        let mut group = "";
        let layout: Vec<Layout<'_>> = self
            .columns
            .iter()
            .enumerate()
            .map(|(i, column)| {
                let over = match column.group == group {
                    true => "",
                    false => column.group.as_str(),
                };
                group = &column.group;
                let entries = printed.iter().filter_map(|row| row.get(i));
                let width = entries.map(|entry| length(entry)).fold(0, usize::max);
                Layout {
                    over,
                    name: &column.name,
                    number: self
                        .rows
                        .iter()
                        .any(|row| matches!(row.get(i), Some(Entry::Number(..)))),
                    width: width.max(length(over)).max(length(&column.name)),
                }
            })
            .collect();
        let mut out = format!("{}\n\n", self.title);
        out += &line(&layout, layout.iter().map(|column| column.over));
        out += &line(&layout, layout.iter().map(|column| column.name));
        for row in &printed {
            out += &line(&layout, row.iter().map(String::as_str));
        }
        if !self.notes.is_empty() {
            out += &format!("\n{}\n", self.notes.join("\n"));
        }
        out
    }
}

/// How a column is laid out.
struct Layout<'a> {
    /// The group's name, over the first of its columns.
    over: &'a str,
    name: &'a str,
    number: bool,
    /// Characters.
    width: usize,
}

fn line<'a>(layout: &[Layout<'_>], entries: impl Iterator<Item = &'a str>) -> String {
    let padded: Vec<String> = layout
        .iter()
        .zip(entries)
        .map(|(column, entry)| match column.number {
            true => format!("{entry:>0$}", column.width),
            false => format!("{entry:<0$}", column.width),
        })
        .collect();
    padded.join("  ").trim_end().to_owned() + "\n"
}

fn length(text: &str) -> usize {
    text.chars().count()
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
