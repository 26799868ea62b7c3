//! What serde has against a text, in words for people: what was given, and what would be right. Its own words name
//! types of the program, which nobody can write into a file.

use crate::nearest::or_nearest;

/// What is wrong with a text of TOML.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Slip<'a> {
    /// A value of another type or out of range, as written, and what is expected there.
    Value { given: String, expected: String },
    /// A word that is not one of these.
    Word { given: &'a str, words: String },
    /// A key that is not one of these.
    Key { given: &'a str, keys: String },
    /// A key that has to be there.
    Missing { key: &'a str },
    /// Anything else, in words that are plain already.
    Other(&'a str),
}

/// Longest value that is repeated in an answer, characters.
const LONGEST: usize = 40;

impl<'a> Slip<'a> {
    /// Reads serde's `message` on the value `written`.
    pub(crate) fn of(message: &'a str, written: &str) -> Self {
        let message = message.trim();
        let quoted = |after: &str| {
            let rest = message.strip_prefix(after)?;
            let (given, rest) = rest.strip_prefix('`')?.split_once('`')?;
            let choices = rest.trim_start_matches(", ");
            let choices = choices.trim_start_matches("expected ");
            let choices = choices.trim_start_matches("one of ").replace('`', "");
            let several = choices.rsplit_once(", ");
            let listed = several.map(|(first, last)| format!("{first} or {last}"));
            Some((given, listed.unwrap_or(choices)))
        };
        if let Some((key, _)) = quoted("missing field ") {
            return Self::Missing { key };
        }
        if let Some((given, keys)) = quoted("unknown field ") {
            return Self::Key { given, keys };
        }
        if let Some((given, words)) = quoted("unknown variant ") {
            return Self::Word { given, words };
        }
        if let Some(tables) = message.strip_prefix("unexpected keys in table: ")
            && let Some((given, keys)) = tables.split_once(", available keys: ")
        {
            let keys = keys.replace('`', "");
            return Self::Key { given, keys };
        }
        if message.starts_with("wanted ") {
            return Self::Value {
                given: given(written),
                expected: plain(message),
            };
        }
        let begins = [
            "invalid type: ",
            "invalid value: ",
            "invalid length ",
            "expected ",
        ];
        let is_of_serde = begins.iter().any(|begin| message.starts_with(begin));
        match message.rsplit_once("expected ") {
            Some((_, expected)) if is_of_serde => Self::Value {
                given: given(written),
                expected: plain(expected),
            },
            _ => Self::Other(message),
        }
    }

    /// The problem and the remedy. `field` is the path of the value, and gets the name of a missing key; `help` is
    /// where more is known of such files.
    pub(crate) fn words(self, field: &mut String, help: &str) -> (String, String) {
        match self {
            Self::Value { given, expected } => {
                let key = field.rsplit('.').next().unwrap_or_default();
                (format!("`{key}` is {given}"), format!("give {expected}"))
            }
            Self::Word { given, words } => (format!("`{given}` is unknown"), meant(given, &words)),
            Self::Key { given, keys } if keys.is_empty() => {
                (format!("there is no key `{given}`"), help.to_owned())
            }
            Self::Key { given, keys } => {
                (format!("there is no key `{given}`"), meant(given, &keys))
            }
            Self::Missing { key } => {
                if !field.is_empty() {
                    field.push('.');
                }
                field.push_str(key);
                (format!("`{key}` is missing"), help.to_owned())
            }
            Self::Other(message) => (message.to_owned(), help.to_owned()),
        }
    }
}

/// What there is to choose from, `h, mode or r`, after the one that was meant.
fn meant(given: &str, choices: &str) -> String {
    let names = choices.split(", ").flat_map(|names| names.split(" or "));
    or_nearest(given, names, &format!("choose {choices}"))
}

/// A value as written, or what sort of value it is if that is long.
fn given(written: &str) -> String {
    let is_short = written.chars().count() <= LONGEST && !written.contains('\n');
    match written.chars().next() {
        None => "another value".to_owned(),
        _ if is_short => format!("`{written}`"),
        Some('{') => "a table".to_owned(),
        Some('[') => "a list".to_owned(),
        Some('"' | '\'') => "a text".to_owned(),
        _ => "another value".to_owned(),
    }
}

/// What serde expects, in plain words.
fn plain(expected: &str) -> String {
    let (sort, rest) = expected.split_once(' ').unwrap_or((expected, ""));
    let plain = match expected {
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" => "a whole number from 0 to 4294967295",
        "u64" | "usize" => "a whole number of 0 or more",
        "i64" | "i32" => "a whole number",
        "f64" | "f32" => "a number",
        "a string" | "string" => "a text in quotes",
        "a boolean" | "boolean" => "true or false",
        "a sequence" | "sequence" => "a list, such as [\"a\", \"b\"]",
        "a map" | "map" => "a table",
        "variant identifier" => "one word in quotes",
        "string or map" => "a word in quotes, or a table",
        "wanted string or table"
        | "wanted exactly 1 element, found 0 elements"
        | "wanted exactly 1 element, more than 1 element" => {
            "a word in quotes, or a table with one key"
        }
        _ => match sort {
            "struct" | "table" => "a table",
            "enum" => "a word in quotes, or a table",
            "tuple" => return format!("a list of {}", number(rest)),
            _ if expected.starts_with("a tuple") => {
                return format!("a list of {}", number(rest));
            }
            _ => expected,
        },
    };
    plain.to_owned()
}

/// The last word, which is a number.
fn number(text: &str) -> &str {
    let is_number = |word: &&str| word.bytes().all(|byte| byte.is_ascii_digit());
    let mut words = text.split([' ', '`', ',']).filter(|word| !word.is_empty());
    words.rfind(is_number).unwrap_or("values")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(message: &str, written: &str) -> String {
        let mut field = "cells.together".to_owned();
        let (problem, remedy) = Slip::of(message, written).words(&mut field, "HELP");
        format!("{field}: {problem}; {remedy}")
    }

    #[test]
    fn what_serde_says_is_told_without_its_types() {
        for (message, written, told) in [
            (
                "invalid value: integer `65536`, expected u16",
                "65536",
                "cells.together: `together` is `65536`; give a whole number from 0 to 65535",
            ),
            (
                "invalid type: string \"many, expected u16\", expected f64",
                "\"many, expected u16\"",
                "cells.together: `together` is `\"many, expected u16\"`; give a number",
            ),
            (
                "invalid type: sequence, expected struct AxesFile",
                "[\n1]",
                "cells.together: `together` is a list; give a table",
            ),
            (
                "missing field `name`",
                "[cells]",
                "cells.together.name: `name` is missing; HELP",
            ),
            (
                "unknown field `hh`, expected one of `h`, `mode`",
                "hh",
                "cells.together: there is no key `hh`; did you mean `h`? If not, choose h or mode",
            ),
            (
                "unknown variant `u`, expected `up` or `down`",
                "'u'",
                "cells.together: `u` is unknown; did you mean `up`? If not, choose up or down",
            ),
            (
                "invalid length 3, expected a tuple of size 2",
                "[1, 2, 3]",
                "cells.together: `together` is `[1, 2, 3]`; give a list of 2",
            ),
            (
                "unclosed table, expected `]`",
                "",
                "cells.together: unclosed table, expected `]`; HELP",
            ),
        ] {
            assert_eq!(words(message, written), told);
        }
    }
}
