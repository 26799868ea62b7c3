//! The values of an axis as a file gives them: one, a list, or so many steps between two.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

/// A number, or a text that says one with its unit.
#[derive(Debug, Clone, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Word {
    Text(String),
    Number(f64),
}

/// What stands behind an axis: a single value is a setting, several are an axis.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Given {
    One(Word),
    Many(#[schemars(with = "Vec<Word>")] Vec<Spanned<Word>>),
    Range(Box<Range>),
}

/// So many values between two, both included.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Range {
    /// The first.
    #[schemars(with = "Word")]
    pub(crate) from: Spanned<Word>,
    /// The last.
    #[schemars(with = "Word")]
    pub(crate) to: Spanned<Word>,
    /// How many values, the two included.
    #[schemars(with = "u32")]
    pub(crate) steps: Spanned<u32>,
    /// `linear`, which is meant if nothing is said, or `log`.
    #[schemars(with = "Option<String>")]
    pub(crate) scale: Option<Spanned<String>>,
}

// Not untagged enums: their errors name no place, and what is wrong with a range would be lost.
impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Words;

        impl Visitor<'_> for Words {
            type Value = Word;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or a text such as \"3ms\"")
            }

            fn visit_str<E>(self, text: &str) -> Result<Word, E> {
                Ok(Word::Text(text.to_owned()))
            }

            fn visit_f64<E>(self, number: f64) -> Result<Word, E> {
                Ok(Word::Number(number))
            }

            fn visit_i64<E>(self, number: i64) -> Result<Word, E> {
                Ok(Word::Number(number as f64))
            }

            fn visit_u64<E>(self, number: u64) -> Result<Word, E> {
                Ok(Word::Number(number as f64))
            }
        }

        deserializer.deserialize_any(Words)
    }
}

impl<'de> Deserialize<'de> for Given {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Values;

        impl<'de> Visitor<'de> for Values {
            type Value = Given;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value, a list of values, or { from, to, steps }")
            }

            fn visit_str<E>(self, text: &str) -> Result<Given, E> {
                Ok(Given::One(Word::Text(text.to_owned())))
            }

            fn visit_f64<E>(self, number: f64) -> Result<Given, E> {
                Ok(Given::One(Word::Number(number)))
            }

            fn visit_i64<E>(self, number: i64) -> Result<Given, E> {
                Ok(Given::One(Word::Number(number as f64)))
            }

            fn visit_u64<E>(self, number: u64) -> Result<Given, E> {
                Ok(Given::One(Word::Number(number as f64)))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Given, A::Error> {
                let mut words = Vec::new();
                while let Some(word) = list.next_element()? {
                    words.push(word);
                }
                Ok(Given::Many(words))
            }

            fn visit_map<A: MapAccess<'de>>(self, keys: A) -> Result<Given, A::Error> {
                let range = Range::deserialize(MapAccessDeserializer::new(keys))?;
                Ok(Given::Range(Box::new(range)))
            }
        }

        deserializer.deserialize_any(Values)
    }
}
