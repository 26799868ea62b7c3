//! The names under which an experiment has programs of one's own.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use crate::client_name::NAMES;

/// Longest name, bytes: it becomes a part of a folder's name, and a column of tables.
const LONGEST: usize = 24;

/// The name of a controller of one's own: of `a` to `z`, digits and `-`, and none of webloop's clients.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct OwnName {
    bytes: [u8; LONGEST],
    length: u8,
}

/// A word that is not the name of a controller of one's own.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadOwnName {
    /// It has other characters, or too many.
    #[error("`{0}` is not a valid name of a controller; use up to {LONGEST} of a-z, 0-9 and -")]
    Characters(String),
    /// One of webloop's clients has it.
    #[error("`{0}` is the name of a client of webloop's; give yours another `name`")]
    Taken(String),
}

impl OwnName {
    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..usize::from(self.length));
        bytes.map_or("", |bytes| std::str::from_utf8(bytes).unwrap_or(""))
    }
}

impl FromStr for OwnName {
    type Err = BadOwnName;

    fn from_str(word: &str) -> Result<Self, BadOwnName> {
        if !text::is_plain(word, LONGEST) {
            return Err(BadOwnName::Characters(word.chars().take(40).collect()));
        }
        if NAMES.contains(&word) {
            return Err(BadOwnName::Taken(word.to_owned()));
        }
        let mut bytes = [0; LONGEST];
        for (to, from) in bytes.iter_mut().zip(word.bytes()) {
            *to = from;
        }
        Ok(OwnName {
            bytes,
            length: word.len() as u8,
        })
    }
}

impl fmt::Display for OwnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for OwnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl Serialize for OwnName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for OwnName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        word.parse().map_err(D::Error::custom)
    }
}

impl JsonSchema for OwnName {
    fn schema_name() -> Cow<'static, str> {
        "OwnName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The name of a controller of one's own.",
            "type": "string",
            "pattern": "^[a-z0-9][a-z0-9-]{0,23}$"
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_short_and_plain_and_no_client_s() {
        let name: OwnName = "my-pi-2".parse().expect("a name");
        assert_eq!(
            (name.as_str(), format!("{name:>9}")),
            ("my-pi-2", "  my-pi-2".to_owned())
        );
        let longest = "x".repeat(LONGEST);
        assert_eq!(
            longest.parse::<OwnName>().map(|name| name.to_string()),
            Ok(longest)
        );
        for word in [
            "",
            "-x",
            "Mine",
            "my pi",
            "a/b",
            "..",
            &"x".repeat(LONGEST + 1),
        ] {
            assert!(
                matches!(word.parse::<OwnName>(), Err(BadOwnName::Characters(_))),
                "{word}"
            );
        }
        assert_eq!(
            "native".parse::<OwnName>(),
            Err(BadOwnName::Taken("native".to_owned()))
        );
    }

    #[test]
    fn names_are_ordered_as_their_texts() {
        let mut names: Vec<OwnName> = ["b", "a-b", "a", "ab"]
            .iter()
            .map(|word| word.parse().expect("a name"))
            .collect();
        names.sort();
        let texts: Vec<&str> = names.iter().map(OwnName::as_str).collect();
        assert_eq!(texts, ["a", "a-b", "ab", "b"]);
    }
}
