//! The values of an axis in a file: one, a list, or a number of steps between two values.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};
use text::Whole;
use toml::Spanned;

/// Most levels of one axis: more than the points of a figure.
const LEVELS_MAX: u32 = 10_000;

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
    pub(crate) steps: Whole<2, LEVELS_MAX>,
    /// `linear`, which is meant if nothing is said, or `log`.
    #[schemars(with = "Option<String>")]
    pub(crate) scale: Option<Spanned<String>>,
}

// Not untagged enums: their errors have no position, and would hide what is wrong with a range.
impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.deserialize_any(Reading { is_axis: false })? {
            Given::One(word) => Ok(word),
            Given::Many(_) | Given::Range(_) => Err(D::Error::custom("a list in a list")),
        }
    }
}

impl<'de> Deserialize<'de> for Given {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reading { is_axis: true })
    }
}

/// Reads a word, or all that an axis accepts.
struct Reading {
    is_axis: bool,
}

impl<'de> Visitor<'de> for Reading {
    type Value = Given;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.is_axis {
            "a value, a list of values, or { from, to, steps }"
        } else {
            "a number, or a text such as \"3ms\""
        })
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
        if !self.is_axis {
            return Err(A::Error::invalid_type(Unexpected::Seq, &self));
        }
        let mut words = Vec::new();
        while let Some(word) = list.next_element()? {
            words.push(word);
        }
        Ok(Given::Many(words))
    }

    fn visit_map<A: MapAccess<'de>>(self, keys: A) -> Result<Given, A::Error> {
        if !self.is_axis {
            return Err(A::Error::invalid_type(Unexpected::Map, &self));
        }
        let range = Range::deserialize(MapAccessDeserializer::new(keys))?;
        Ok(Given::Range(Box::new(range)))
    }
}
