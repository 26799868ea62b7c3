//! The timings of the two ends: those of a client, as measured, or ideal ones of 0.

use std::fmt;
use std::str::FromStr;

use crate::client::Client;

/// The time that the programs of both ends take for a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Machine {
    /// No time: only deadlines, ticks and the link remain.
    Ideal,
    /// The time that this client takes.
    Of(Client),
}

/// A word that is neither `ideal` nor a client.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("client `{0}` is unknown; choose ideal, {choices}", choices = Client::choices())]
pub struct UnknownMachine(String);

impl FromStr for Machine {
    type Err = UnknownMachine;

    fn from_str(word: &str) -> Result<Self, UnknownMachine> {
        if word == "ideal" {
            return Ok(Machine::Ideal);
        }
        let client = word.parse().map_err(|_| UnknownMachine(word.to_owned()))?;
        Ok(Machine::Of(client))
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Machine::Ideal => f.pad("ideal"),
            Machine::Of(client) => client.fmt(f),
        }
    }
}
