//! Messages as JSON objects, with the fields of their text form.
//!
//! Read as strictly as a query: each field once and no other, numbers finite, and an object, where serde would take a
//! list of the fields' values too.

use std::fmt;

use control::Signals;
use serde::de::{DeserializeOwned, Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

use crate::message::{Answer, Command, Request};
use crate::query::{InvalidMessage, MAX_BYTES};
use crate::setting::Mode;

/// Number of characters of what is wrong that are told.
const WHY_CHARS: usize = 100;

/// The fields of a [`Request`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequestFields {
    #[serde(default)]
    seq: Option<WholeNumber>,
    #[serde(default)]
    t_send_ns: Option<WholeNumber>,
    u: Signals,
}

/// A whole number from 0 to 2^64 - 1. JSON knows no other numbers than numbers, so `7.0` is one too.
struct WholeNumber(u64);

impl<'de> Deserialize<'de> for WholeNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberVisitor;
        impl Visitor<'_> for NumberVisitor {
            type Value = WholeNumber;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a whole number from 0 to {}", u64::MAX)
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<WholeNumber, E> {
                Ok(WholeNumber(number))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<WholeNumber, E> {
                let number = u64::try_from(number);
                let wrong = |_| E::invalid_value(Unexpected::Other("a number below 0"), &self);
                number.map(WholeNumber).map_err(wrong)
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<WholeNumber, E> {
                /// The least that is too great.
                const END: f64 = u64::MAX as f64;
                if (0.0..END).contains(&number) && number.fract() == 0.0 {
                    Ok(WholeNumber(number as u64))
                } else {
                    Err(E::invalid_type(Unexpected::Float(number), &self))
                }
            }
        }
        deserializer.deserialize_any(NumberVisitor)
    }
}

/// A command as an object.
#[must_use]
pub fn command(command: &Command) -> String {
    serde_json::to_string(command).expect("numbers under fixed names")
}

/// Reads a command as a plant takes it.
///
/// # Errors
/// [`InvalidMessage::TooLong`], or [`InvalidMessage::Json`] with what is wrong and where.
pub fn request(text: &[u8]) -> Result<Request, InvalidMessage> {
    let RequestFields { seq, t_send_ns, u } = object(text)?;
    Ok(Request {
        seq: seq.map(|whole| whole.0),
        t_send_ns: t_send_ns.map(|whole| whole.0),
        u,
    })
}

/// Reads the answer to `command`.
///
/// # Errors
/// Those of [`request`], and [`InvalidMessage::OtherCommand`].
pub fn answer(mode: Mode, text: &str, command: &Command) -> Result<Answer, InvalidMessage> {
    let text = text.as_bytes();
    let answer = match mode {
        Mode::Closed => Answer::State(object(text)?),
        Mode::Open => Answer::Acknowledgement(object(text)?),
    };
    answer.to(command)
}

fn object<T: DeserializeOwned>(text: &[u8]) -> Result<T, InvalidMessage> {
    if text.len() > MAX_BYTES {
        return Err(InvalidMessage::TooLong { bytes: text.len() });
    }
    if !text.trim_ascii_start().starts_with(b"{") {
        return Err(InvalidMessage::Json {
            why: "it is no object".to_owned(),
        });
    }
    serde_json::from_slice(text).map_err(|error| InvalidMessage::Json {
        why: text::excerpt_of_line(&error.to_string(), WHY_CHARS),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::message::State;

    #[test]
    fn what_is_no_object_with_these_fields_is_told() {
        for (text, says) in [
            ("", "no object"),
            ("[1,2,3]", "no object"),
            ("{}", "missing field `u`"),
            (r#"{"u":null}"#, "did not match"),
            (r#"{"u":"1"}"#, "did not match"),
            (r#"{"u":[1,2,3]}"#, "did not match"),
            (r#"{"u":1e400}"#, "out of range"),
            (r#"{"u":1,"u":2}"#, "duplicate field `u`"),
            (r#"{"u":1,"v":2}"#, "unknown field `v`"),
            (r#"{"u":1,"seq":-1}"#, "invalid value"),
            (r#"{"u":1,"seq":1.5}"#, "invalid type"),
            (r#"{"u":1} x"#, "trailing characters"),
            (r#"{"u":1"#, "EOF"),
        ] {
            let error = request(text.as_bytes()).expect_err(text).to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
        let long = format!("{{\"u\":1{}}}", " ".repeat(MAX_BYTES));
        let error = request(long.as_bytes()).expect_err("long");
        assert!(matches!(error, InvalidMessage::TooLong { .. }));
        let floats = request(br#"{"u":1,"seq":7.0,"t_send_ns":1e3}"#).expect("whole numbers");
        assert_eq!((floats.seq, floats.t_send_ns), (Some(7), Some(1_000)));
        assert!(request(br#"{"u":1,"seq":18446744073709551616}"#).is_err());
        let simple = request(b" {\"u\":[1,-2]}").expect("a command");
        assert_eq!((simple.seq, simple.u.second), (None, Some(-2.0)));
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_to_the_last_bit(
            seq in any::<u64>(), t_send_ns in any::<u64>(), u in -1e9..1e9_f64,
            second in prop::option::of(-1e9..1e9_f64),
        ) {
            let u = Signals { first: u, second };
            let one = Command { seq, t_send_ns, u };
            let read = request(command(&one).as_bytes()).expect("what was written");
            prop_assert_eq!(read, Request::from(&one));
            let state = State { seq, tick: seq, t_arrive_ns: t_send_ns, y: u, u };
            let text = serde_json::to_string(&Answer::State(state)).expect("plain fields");
            prop_assert_eq!(answer(Mode::Closed, &text, &one), Ok(Answer::State(state)));
            let other = Command { seq: seq.wrapping_add(1), ..one };
            prop_assert!(answer(Mode::Closed, &text, &other).is_err());
            prop_assert!(answer(Mode::Open, &text, &one).is_err());
        }

        #[test]
        fn no_bytes_make_it_panic(text in prop::collection::vec(any::<u8>(), 0..2_000)) {
            let _ = request(&text);
        }
    }
}
