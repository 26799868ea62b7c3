//! What a column says of itself: its name, the type of its entries, and what they mean.

use serde::Serialize;

/// A column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Its name in the header, with the unit at its end.
    pub name: &'static str,
    /// The type of its entries.
    pub entry: EntryType,
    /// Whether no entry is empty.
    pub is_required: bool,
    /// The words that are allowed; empty if any are.
    pub words: &'static [&'static str],
    /// The comment on its field, line by line.
    comment: &'static str,
}

/// The type of a column's entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EntryType {
    /// Whole numbers. Times in ns have up to 16 digits, which a double just holds.
    Integer,
    /// Numbers.
    Number,
    /// `true` or `false`.
    Boolean,
    /// Words.
    String,
}

/// What can be an entry of a column.
pub trait Typed {
    /// The type of the entries.
    const ENTRY: EntryType;
    /// Whether no entry is empty.
    const IS_REQUIRED: bool = true;
    /// The words that are allowed; empty if any are.
    const WORDS: &'static [&'static str] = &[];
}

/// Types whose entries are never empty, and may be anything of their kind.
macro_rules! typed {
    ($($entry:ident: $($type:ty),+;)+) => {$($(
        impl Typed for $type {
            const ENTRY: EntryType = EntryType::$entry;
        }
    )+)+};
}

typed! {
    Integer: u32, u64;
    Number: f64;
    Boolean: bool;
    String: String;
}

impl<T: Typed> Typed for Option<T> {
    const ENTRY: EntryType = T::ENTRY;
    const IS_REQUIRED: bool = false;
    const WORDS: &'static [&'static str] = T::WORDS;
}

impl Column {
    /// The column of a field of type `T`, under which `comment` stands in the code, line by line.
    #[must_use]
    pub const fn of<T: Typed>(name: &'static str, comment: &'static str) -> Column {
        Column {
            name,
            entry: T::ENTRY,
            is_required: T::IS_REQUIRED,
            words: T::WORDS,
            comment,
        }
    }

    /// What an entry means, as a phrase: the first paragraph of the comment, without capital and full stop. What
    /// follows in the comment is for developers alone.
    #[must_use]
    pub fn meaning(&self) -> String {
        let lines = self.comment.lines().map(str::trim);
        let first: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
        let sentence = first.join(" ");
        let phrase = sentence.strip_suffix('.').unwrap_or(&sentence);
        let mut signs = phrase.chars();
        match (signs.next(), signs.clone().next()) {
            // A name, such as IPv4, keeps its capitals.
            (Some(first), Some(second)) if !second.is_uppercase() => {
                first.to_lowercase().chain(signs).collect()
            }
            _ => phrase.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_meaning_is_the_first_paragraph_as_a_phrase() {
        let of = |comment| Column::of::<u64>("n", comment).meaning();
        assert_eq!(
            of(" When it came,\n monotonic.\n"),
            "when it came, monotonic"
        );
        assert_eq!(of(" Its end.\n\n Not its start.\n"), "its end");
        assert_eq!(
            of(" IPv4 packets. Lost ones too.\n"),
            "IPv4 packets. Lost ones too"
        );
        assert_eq!(of(""), "");
    }

    #[test]
    fn what_may_be_nothing_is_of_the_same_type() {
        let column = Column::of::<Option<u64>>("n", "");
        assert_eq!(
            (column.entry, column.is_required),
            (EntryType::Integer, false)
        );
        assert!(Column::of::<f64>("x", "").is_required);
    }
}
