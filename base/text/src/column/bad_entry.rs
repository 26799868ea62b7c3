//! What is wrong with a text that should be an entry of a column.

/// Number of characters of a rejected text that an error quotes.
const EXCERPT_CHARS: usize = 40;

/// Why a text is not an entry of its column. Each quotes its beginning, escaped for one line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadEntry {
    /// No whole number, or too great a one.
    #[error("`{text}` is not a whole number from 0 to {most}")]
    Count {
        /// The text.
        text: String,
        /// The greatest that there can be.
        most: u64,
    },
    /// No finite number.
    #[error("`{text}` is not a finite decimal number; write it like 0.35 or -1e-3")]
    Number {
        /// The text.
        text: String,
    },
    /// None of the words.
    #[error("`{text}` is unknown; choose one of {}", words.join(", "))]
    Word {
        /// The text.
        text: String,
        /// The words.
        words: &'static [&'static str],
    },
}

impl BadEntry {
    /// `text` is no whole number up to `most`.
    pub(crate) fn count(text: &str, most: u64) -> BadEntry {
        let text = excerpt(text);
        BadEntry::Count { text, most }
    }

    /// `text` is no finite number.
    pub(crate) fn number(text: &str) -> BadEntry {
        let text = excerpt(text);
        BadEntry::Number { text }
    }

    /// `text` is none of these words.
    pub(crate) fn word(text: &str, words: &'static [&'static str]) -> BadEntry {
        let text = excerpt(text);
        BadEntry::Word { text, words }
    }
}

/// The beginning of a text from outside, escaped for one line.
fn excerpt(text: &str) -> String {
    crate::plain::excerpt_of_line(text, EXCERPT_CHARS)
}
