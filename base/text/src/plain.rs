//! Texts from outside, made harmless where they are shown.
//!
//! A name, a file's path or a program's last words may hold characters that move a terminal's cursor, change its
//! colours or title, or turn the order of a line around. They are shown by their codes.

use std::borrow::Cow;

/// The text with each control character by its code, as `\u{1b}`; ends of lines and tabs stay.
#[must_use]
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_active) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for letter in text.chars() {
        if is_active(letter) {
            shown.extend(letter.escape_unicode());
        } else {
            shown.push(letter);
        }
    }
    shown.into()
}

/// The beginning of a text, of `most` characters at most, made [`plain`].
#[must_use]
pub fn excerpt(text: &str, most: usize) -> String {
    let start: String = text.chars().take(most).collect();
    plain(&start).into_owned()
}

/// The beginning of a text, of `most` characters at most, for a line and between quotes: whatever is not seen, and
/// quotes, by their escapes, and `...` where the text goes on.
#[must_use]
pub fn excerpt_of_line(text: &str, most: usize) -> String {
    let start = text.chars().take(most);
    let mut start: String = start.flat_map(char::escape_debug).collect();
    if text.chars().nth(most).is_some() {
        start.push_str("...");
    }
    start
}

/// Whether a character does something else than to be seen.
#[must_use]
pub fn is_active(letter: char) -> bool {
    (letter.is_control() && !matches!(letter, '\n' | '\t'))
        || matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_is_shown_and_what_is_seen_stays() {
        for (text, shown) in [
            ("", ""),
            (
                "a line\n\tand another, é ü 日本",
                "a line\n\tand another, é ü 日本",
            ),
            ("\x1b[31mred\x1b[0m", "\\u{1b}[31mred\\u{1b}[0m"),
            ("\x1b]0;title\x07", "\\u{1b}]0;title\\u{7}"),
            ("one\rtwo\x08\x7f\0", "one\\u{d}two\\u{8}\\u{7f}\\u{0}"),
            ("\u{9b}31m", "\\u{9b}31m"),
            ("a\u{202e}b\u{2066}c", "a\\u{202e}b\\u{2066}c"),
        ] {
            assert_eq!(plain(text), shown);
            assert!(!plain(text).chars().any(is_active));
        }
    }

    #[test]
    fn an_excerpt_has_so_many_characters_of_the_text_however_they_are_shown() {
        assert_eq!(excerpt("é\x1b\n\"日本", 4), "é\\u{1b}\n\"");
        assert_eq!(excerpt("short", 40), "short");
        assert_eq!(excerpt_of_line("é\x1b\n\"日本", 4), "é\\u{1b}\\n\\\"...");
        assert_eq!(excerpt_of_line("short", 5), "short");
    }
}
