//! One value or a list of them, as an experiment has behind most of its keys: typed text, with its places.

use std::fmt;
use std::ops::Range;

use crate::system::Program;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

use crate::invalid::Word;

/// One value, or a list of them: `"3ms"`, `["1ms", "3ms"]`, `8`, `0.5`, `[1, 8, "unlimited"]`. A client may also
/// be a table: `{ name = "mine", run = ["./mine"] }`.
#[derive(Debug, Clone, Default)]
pub(crate) struct List {
    span: Range<usize>,
    words: Vec<Word>,
    /// Programs of one's own, with their names; their words are among the others.
    programs: Vec<(Word, Program)>,
}

/// A program of one's own, as a client.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OwnClient {
    /// Its name, in tables and folders: up to 24 of a-z, 0-9 and -.
    pub(crate) name: String,
    /// The program and its arguments. A word that begins with `./` is beside the experiment's file. What its
    /// image starts by itself, if not given.
    #[serde(default)]
    pub(crate) run: Vec<String>,
    /// The container image that it runs in, with `--backend compose`; webloop's with Python, if not given.
    #[serde(default)]
    pub(crate) image: Option<String>,
}

impl List {
    /// The words, in order.
    pub(crate) fn words(&self) -> &[Word] {
        &self.words
    }

    /// The programs of one's own among them, with their names.
    pub(crate) fn programs(&self) -> &[(Word, Program)] {
        &self.programs
    }

    /// The words, with the place of the list.
    pub(crate) fn placed(&self) -> Spanned<Vec<Word>> {
        Spanned::new(self.span.clone(), self.words.clone())
    }

    /// A list of nothing at a place.
    pub(crate) fn at(span: Range<usize>) -> List {
        List {
            span,
            ..List::default()
        }
    }

    /// Replaces the values by these words, at the place of the list.
    pub(crate) fn replace(&mut self, words: &[String]) {
        let placed = |word: &String| Spanned::new(self.span.clone(), word.clone());
        self.words = words.iter().map(placed).collect();
    }

    /// Keeps only the values that are one of these.
    pub(crate) fn keep(&mut self, words: &[String]) {
        self.words.retain(|own| words.contains(own.get_ref()));
    }
}

impl<'de> Deserialize<'de> for List {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let written = Spanned::<Written>::deserialize(deserializer)?;
        let span = written.span();
        let values = match written.into_inner() {
            Written::One(value) => vec![Spanned::new(span.clone(), value)],
            Written::Several(values) => values,
        };
        let mut list = List {
            span,
            ..List::default()
        };
        for value in values {
            let place = value.span();
            let word = match value.into_inner() {
                Value::Word(word) => word,
                Value::Program(OwnClient { name, run, image }) => {
                    let program = Program {
                        run,
                        image,
                        folder: None,
                    };
                    list.programs
                        .push((Spanned::new(place.clone(), name.clone()), program));
                    name
                }
            };
            list.words.push(Spanned::new(place, word));
        }
        Ok(list)
    }
}

/// A list, or a single value.
enum Written {
    One(Value),
    Several(Vec<Spanned<Value>>),
}

/// One value: text, a number as text, or a program of one's own.
enum Value {
    Word(String),
    Program(OwnClient),
}

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reading { is_list: true })
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.deserialize_any(Reading { is_list: false })? {
            Written::One(value) => Ok(value),
            Written::Several(_) => Err(D::Error::custom("a list in a list")),
        }
    }
}

/// Reads a value or, if `is_list`, also a list of values.
struct Reading {
    is_list: bool,
}

impl<'de> Visitor<'de> for Reading {
    type Value = Written;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.is_list {
            "a value in quotes, or a list of them"
        } else {
            "a value in quotes"
        })
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Written, E> {
        Ok(Written::One(Value::Word(word.to_owned())))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Written, E> {
        Ok(Written::One(Value::Word(number.to_string())))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Written, E> {
        Ok(Written::One(Value::Word(number.to_string())))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Written, A::Error> {
        let program = OwnClient::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Written::One(Value::Program(program)))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Written, A::Error> {
        if !self.is_list {
            return Err(A::Error::invalid_type(serde::de::Unexpected::Seq, &self));
        }
        let mut words = Vec::new();
        while let Some(word) = seq.next_element()? {
            words.push(word);
        }
        Ok(Written::Several(words))
    }
}
