//! How long the plant holds a command if no other comes: forever, or for a time and then 0.
//!
//! The paper's plant holds the last command, and so keeps it when its controller is gone. With a
//! watchdog its input becomes 0 after a time.

use std::{fmt, str::FromStr};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::span::{span_ns, span_text};

/// What the plant's input is while no command comes. Written `last`, or as a time: `100ms`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
pub enum Hold {
    /// The last command, for ever.
    #[default]
    Last,
    /// The last command for a time, then 0.
    For {
        /// How long, from the command's arrival; more than 0.
        ns: u64,
    },
}

/// A text that is not a hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "hold `{text}` is unknown; write `last`, or a time above zero like 100ms, after which the \
     plant's input is 0"
)]
pub struct InvalidHold {
    /// The text.
    text: String,
}

impl Hold {
    /// Whether it is the plants' default.
    #[must_use]
    pub fn is_last(&self) -> bool {
        *self == Self::Last
    }
}

impl FromStr for Hold {
    type Err = InvalidHold;

    fn from_str(text: &str) -> Result<Self, InvalidHold> {
        if text == "last" {
            return Ok(Self::Last);
        }
        match span_ns(text) {
            Some(ns) if ns > 0 => Ok(Self::For { ns }),
            _ => Err(InvalidHold {
                text: text.to_owned(),
            }),
        }
    }
}

impl fmt::Display for Hold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Last => f.pad("last"),
            Self::For { ns } => f.pad(&span_text(*ns)),
        }
    }
}

impl TryFrom<String> for Hold {
    type Error = InvalidHold;

    fn try_from(text: String) -> Result<Self, InvalidHold> {
        text.parse()
    }
}

impl From<Hold> for String {
    fn from(hold: Hold) -> Self {
        hold.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_read_as_it_is_written() {
        for text in ["last", "100ms", "2500us", "1s"] {
            let hold: Hold = text.parse().expect(text);
            assert_eq!(hold.to_string(), text);
        }
        for text in ["", "0ms", "100", "never", "-1s"] {
            assert!(text.parse::<Hold>().is_err(), "{text}");
        }
    }
}
