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
}
