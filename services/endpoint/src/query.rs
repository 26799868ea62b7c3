//! Reads `key=value&key=value` strictly.
//!
//! Every key is there once, but for those that a message may leave out, and no other: a misspelt or
//! repeated key is a mistake of a client, which then should not control anything. Numbers are decimal and finite. Writing needs no
//! code here: the messages' `Display` does it, since no character of a number needs escaping.

use std::borrow::Cow;

use control::Signals;

/// Longest query that is accepted. The longest valid command has about 100 bytes.
pub const MAX_BYTES: usize = 1024;

/// Number of characters of a rejected text that an error quotes.
const EXCERPT_CHARS: usize = 40;

/// Why a message was rejected. Each variant names the field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidMessage {
    /// The whole text is too long.
    #[error("query of {bytes} bytes: a message has at most {MAX_BYTES}")]
    TooLong {
        /// Length of the query in bytes.
        bytes: usize,
    },
    /// A field is missing.
    #[error("field `{field}` is missing: this message has the fields {expected}")]
    Missing {
        /// Name of the missing field.
        field: &'static str,
        /// All fields of the message.
        expected: String,
    },
    /// A field appears twice.
    #[error("field `{field}` appears twice: give it once")]
    Duplicate {
        /// Name of the repeated field.
        field: &'static str,
    },
    /// The message has no such field.
    #[error("field `{field}` is unknown: this message has the fields {expected}")]
    Unknown {
        /// The field, shortened.
        field: String,
        /// All fields of the message.
        expected: String,
    },
    /// The value is not a whole number from 0 to 2^64 - 1.
    #[error("field `{field}`: `{value}` is not {}{}", whole(field), plus(value))]
    NotCount {
        /// Name of the field.
        field: &'static str,
        /// Its value, shortened.
        value: String,
    },
    /// The value is not a finite number.
    #[error(
        "field `{field}`: `{value}` is not a finite decimal number; write it like 0.35 or -1e-3{}",
        plus(value)
    )]
    NotFinite {
        /// Name of the field.
        field: &'static str,
        /// Its value, shortened.
        value: String,
    },
    /// There are more values than a plant has inputs or outputs, or others than this one has.
    #[error("field `{field}` has {}; {needed}", if *given == 1 { "one number".to_owned() } else { format!("{given} numbers") })]
    Signals {
        /// Name of the field.
        field: &'static str,
        /// How many numbers it has.
        given: usize,
        /// How many there must be, in words.
        needed: &'static str,
    },
    /// The value is neither `true` nor `false`.
    #[error("field `{field}`: `{value}` is neither `true` nor `false`")]
    NotFlag {
        /// Name of the field.
        field: &'static str,
        /// Its value, shortened.
        value: String,
    },
    /// The text is not the message as a JSON object.
    #[error("not a message in JSON: {why}; write it like {{\"seq\":7,\"u\":0.35}}")]
    Json {
        /// What is wrong, and where.
        why: String,
    },
    /// The message is not the one that was sent.
    #[error("checksum mismatch (`crc` {told}, computed {own}): the message was altered on its way")]
    Checksum {
        /// What the message says, shortened.
        told: String,
        /// What it should say.
        own: String,
    },
    /// The message has no checksum, and needs one.
    #[error(
        "field `crc` is missing: here every message ends with its checksum, `&crc=` and eight hex digits"
    )]
    NoChecksum,
    /// The answer belongs to another command.
    #[error("field `seq`: the answer is to command {got}, the command was {asked}")]
    OtherCommand {
        /// The sequence number of the command.
        asked: u64,
        /// The sequence number in the answer.
        got: u64,
    },
}

/// What a field that is counted must be.
fn whole(field: &str) -> &'static str {
    if field.ends_with("_ns") {
        "a time in whole nanoseconds, without a unit, from 0 to 18446744073709551615"
    } else {
        "a whole number from 0 to 18446744073709551615"
    }
}

/// What to do about a space in a number, which was a plus.
fn plus(value: &str) -> &'static str {
    if value.contains(' ') {
        "; a + in a query is a space, so write %2B, or leave it out"
    } else {
        ""
    }
}

/// The values of the fields `names`, in that order.
pub(crate) fn fields<'a, const N: usize>(
    text: &'a str,
    names: [&'static str; N],
) -> Result<[Cow<'a, str>; N], InvalidMessage> {
    Ok(fields_of(text, names, N)?.map(Option::unwrap_or_default))
}

/// The values of the fields `names`, in that order, of which the first `needed` must be there.
pub(crate) fn fields_of<'a, const N: usize>(
    text: &'a str,
    names: [&'static str; N],
    needed: usize,
) -> Result<[Option<Cow<'a, str>>; N], InvalidMessage> {
    if text.len() > MAX_BYTES {
        return Err(InvalidMessage::TooLong { bytes: text.len() });
    }
    let expected = || names.join(", ");
    let mut values: [Option<Cow<'a, str>>; N] = [const { None }; N];
    for (key, value) in pairs(text) {
        let Some(index) = names.iter().position(|name| *name == key) else {
            return Err(InvalidMessage::Unknown {
                field: excerpt(&key),
                expected: expected(),
            });
        };
        if values[index].replace(value).is_some() {
            return Err(InvalidMessage::Duplicate {
                field: names[index],
            });
        }
    }
    let missing = values.iter().zip(names).take(needed);
    if let Some((_, field)) = missing.into_iter().find(|(value, _)| value.is_none()) {
        return Err(InvalidMessage::Missing {
            field,
            expected: expected(),
        });
    }
    Ok(values)
}

/// The keys and values of a form.
fn pairs(text: &str) -> impl Iterator<Item = (Cow<'_, str>, Cow<'_, str>)> {
    // Nothing of what webloop writes is encoded.
    let is_plain = !text.bytes().any(|byte| byte == b'%' || byte == b'+');
    let (mut plain, encoded) = if is_plain { (text, "") } else { ("", text) };
    let plain = std::iter::from_fn(move || {
        let (pair, rest) = cut(plain, b'&');
        let is_over = plain.is_empty();
        plain = rest;
        (!is_over).then_some(pair)
    });
    let plain = plain.filter(|pair| !pair.is_empty()).map(|pair| {
        let (key, value) = cut(pair, b'=');
        (key.into(), value.into())
    });
    plain.chain(form_urlencoded::parse(encoded.as_bytes()))
}

/// What is before a byte of ASCII, and what is behind it; nothing is, where it is missing. For texts of some ten
/// bytes std's search takes four times as long.
fn cut(text: &str, at: u8) -> (&str, &str) {
    match text.bytes().position(|byte| byte == at) {
        Some(place) => (&text[..place], &text[place + 1..]),
        None => (text, ""),
    }
}

/// A count or a time in nanoseconds: digits only, so neither `+7` nor ` 7`.
pub(crate) fn count(field: &'static str, value: &str) -> Result<u64, InvalidMessage> {
    let digits = value.bytes().all(|byte| byte.is_ascii_digit());
    match value.parse() {
        Ok(number) if digits => Ok(number),
        _ => Err(InvalidMessage::NotCount {
            field,
            value: excerpt(value),
        }),
    }
}

/// `true` or `false`.
pub(crate) fn flag(field: &'static str, value: &str) -> Result<bool, InvalidMessage> {
    value.parse().map_err(|_| InvalidMessage::NotFlag {
        field,
        value: excerpt(value),
    })
}

/// A finite number. `1e400` is infinite as an f64 and is rejected too.
pub(crate) fn finite(field: &'static str, value: &str) -> Result<f64, InvalidMessage> {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(InvalidMessage::NotFinite {
            field,
            value: excerpt(value),
        }),
    }
}

/// A finite number, or two with a comma between them.
pub(crate) fn signals(field: &'static str, value: &str) -> Result<Signals, InvalidMessage> {
    let Some((first, second)) = value.split_once(',') else {
        return Ok(finite(field, value)?.into());
    };
    if second.contains(',') {
        return Err(InvalidMessage::Signals {
            field,
            given: value.split(',').count(),
            needed: if field == "u" {
                "a plant has one or two inputs"
            } else {
                "a plant has one or two outputs"
            },
        });
    }
    Ok([finite(field, first)?, finite(field, second)?].into())
}

/// The beginning of a text from outside, escaped for a log line.
pub(crate) fn excerpt(text: &str) -> String {
    text::excerpt_of_line(text, EXCERPT_CHARS)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_form_is_what_a_general_library_takes_it_for(text in "([a-z0-9&=.,;%+ é-]|%2[0-9a-f]){0,24}") {
            let own: Vec<_> = pairs(&text).collect();
            let others: Vec<_> = form_urlencoded::parse(text.as_bytes()).collect();
            prop_assert_eq!(own, others);
        }
    }
}
