//! Who closes the loop: the paper's question.

use std::fmt;
use std::str::FromStr;

use endpoint::{Preset, Transport};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A program that can be the controller.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Client {
    /// webloop's own, in Rust.
    #[default]
    Native,
    /// The paper's, in Python.
    Python,
    /// A page in Chromium, or in Chrome.
    Chromium,
    /// A page in Firefox.
    Firefox,
}

impl Client {
    /// All of them.
    pub const ALL: [Client; 4] = [
        Client::Native,
        Client::Python,
        Client::Chromium,
        Client::Firefox,
    ];

    /// Whether it is a page in a browser.
    #[must_use]
    pub fn is_browser(self) -> bool {
        matches!(self, Client::Chromium | Client::Firefox)
    }

    /// Whether a message that finds no connection idle waits for the one that is opened for it, and
    /// not for whichever is free first: each worker of the Python client keeps its own.
    #[must_use]
    pub fn keeps_own_connections(self) -> bool {
        self == Client::Python
    }

    /// A message's IP packets, a request up and its answer down, on average: what takes time where
    /// there is a rate limit. As counted on real links, but for browsers: theirs are reckoned from
    /// their heads.
    #[must_use]
    pub fn message_bytes(self, transport: Transport) -> [u32; 2] {
        match (transport, self) {
            (Transport::WebSocket, _) => [112, 139],
            (Transport::Http, Client::Native) => [166, 288],
            (Transport::Http, Client::Python) => [179, 287],
            (Transport::Http, Client::Chromium | Client::Firefox) => [520, 400],
        }
    }

    /// Its settings where an experiment names none: what suits it best.
    #[must_use]
    pub fn preset(self) -> Preset {
        match self.is_browser() {
            true => Preset::Worker,
            false => Preset::PaperPython,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Client::Native => "native",
            Client::Python => "python",
            Client::Chromium => "chromium",
            Client::Firefox => "firefox",
        }
    }
}

/// A word that no client has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("client `{0}` is unknown; choose native, python, chromium or firefox")]
pub struct UnknownClient(String);

impl FromStr for Client {
    type Err = UnknownClient;

    fn from_str(word: &str) -> Result<Self, UnknownClient> {
        Client::ALL
            .into_iter()
            .find(|client| client.word() == word)
            .ok_or_else(|| UnknownClient(word.to_owned()))
    }
}

impl fmt::Display for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_is_read_as_it_is_written_and_as_a_plan_has_it() {
        for client in Client::ALL {
            assert_eq!(client.to_string().parse(), Ok(client));
            let json = serde_json::to_value(client).expect("a word");
            assert_eq!(json, client.to_string());
        }
    }
}
