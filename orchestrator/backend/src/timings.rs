//! How long each client and its plant take over messages, by measurement: for virtual time.

use plan::Client;
use serde::{Deserialize, Serialize};
use sim::Timing;

/// What was measured on the machine that webloop is built on; `webloop calibrate` does it on yours.
const BUILT_IN: &str = include_str!("timings.toml");

/// A [`Timing`] for each client.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timings {
    /// webloop's own client.
    pub native: Timing,
    /// The paper's.
    pub python: Timing,
    /// A page in Chromium.
    pub chromium: Timing,
    /// A page in Firefox.
    pub firefox: Timing,
}

/// A text that holds no timings.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidTimings(String);

impl Timings {
    /// Those that the binary carries.
    ///
    /// # Errors
    /// Never, as a test shows.
    pub fn built_in() -> Result<Timings, InvalidTimings> {
        Timings::read(BUILT_IN)
    }

    /// Reads them from a TOML text, as `webloop calibrate` writes it.
    ///
    /// # Errors
    /// What is wrong, with line and column.
    pub fn read(text: &str) -> Result<Timings, InvalidTimings> {
        toml::from_str(text).map_err(|problem| InvalidTimings(problem.to_string()))
    }

    /// Them as a TOML text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        const HEAD: &str = "\
# How long programs take over a message, in ns, as measured: one number, or the quantiles from 0 to 1
# in steps of 1/32. What each is, is in orchestrator/sim/src/timing.rs.
";
        // Plain data of numbers: serialising it cannot fail.
        HEAD.to_owned() + &toml::to_string(self).unwrap_or_default()
    }

    /// Those of a client.
    #[must_use]
    pub fn of(&self, client: Client) -> &Timing {
        match client {
            Client::Native => &self.native,
            Client::Python => &self.python,
            Client::Chromium => &self.chromium,
            Client::Firefox => &self.firefox,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_ones_are_whole() {
        let timings = Timings::built_in().expect("built in");
        assert!(timings.native.up_ns.median_ns() < timings.python.up_ns.median_ns());
    }
}
