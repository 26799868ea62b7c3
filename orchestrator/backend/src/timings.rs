//! How long each client and its plant take over messages, by measurement: for virtual time.

use std::collections::BTreeMap;

use endpoint::{SampleTime, Thread};
use plan::{Cell, Client};
use serde::{Deserialize, Serialize};
use sim::Timing;

/// What was measured on the machine that webloop is built on; `webloop calibrate` does it on yours.
const BUILT_IN: &str = include_str!("timings.toml");

/// How long each client takes, at each sample time that was measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Timings {
    /// webloop's own client.
    pub native: Rates,
    /// The paper's.
    pub python: Rates,
    /// A page in Chromium, in a worker.
    pub chromium: Rates,
    /// The same on its main thread, with setTimeout.
    pub chromium_main: Rates,
    /// A page in Firefox, in a worker.
    pub firefox: Rates,
    /// The same on its main thread, with setTimeout.
    pub firefox_main: Rates,
}

/// A [`Timing`] for each sample time that was measured: who sends seldom sleeps between, and is
/// slower to wake.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    try_from = "BTreeMap<SampleTime, Timing>",
    into = "BTreeMap<SampleTime, Timing>"
)]
pub struct Rates(BTreeMap<SampleTime, Timing>);

impl Rates {
    /// The timing of the sample time next to `h`, by their ratio.
    #[must_use]
    pub fn near(&self, h: SampleTime) -> &Timing {
        let slower = self.0.range(h..).next();
        let faster = self.0.range(..h).next_back();
        match (faster, slower) {
            (Some((_, only)), None) | (None, Some((_, only))) => only,
            (Some((below, timing)), Some((above, other))) => {
                // h/below < above/h, without a quotient.
                let square = u128::from(h.ns()) * u128::from(h.ns());
                match square < u128::from(below.ns()) * u128::from(above.ns()) {
                    true => timing,
                    false => other,
                }
            }
            (None, None) => &Timing::IDEAL,
        }
    }
}

impl TryFrom<BTreeMap<SampleTime, Timing>> for Rates {
    type Error = &'static str;

    fn try_from(rates: BTreeMap<SampleTime, Timing>) -> Result<Self, Self::Error> {
        match rates.is_empty() {
            true => Err("a client needs the timing of at least one sample time"),
            false => Ok(Self(rates)),
        }
    }
}

impl From<Rates> for BTreeMap<SampleTime, Timing> {
    fn from(rates: Rates) -> Self {
        rates.0
    }
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

    /// Those of a cell's client, at its sample time.
    #[must_use]
    pub fn of(&self, cell: &Cell) -> &Timing {
        let on_main = cell.page.is_some_and(|page| page.thread == Thread::Main);
        self.rates(cell.client, on_main).near(cell.settings.h)
    }

    /// Those of a client, which on its page's main thread has others than in a worker.
    #[must_use]
    pub fn rates(&self, client: Client, on_main: bool) -> &Rates {
        match (client, on_main) {
            (Client::Native, _) => &self.native,
            (Client::Python, _) => &self.python,
            (Client::Chromium, false) => &self.chromium,
            (Client::Chromium, true) => &self.chromium_main,
            (Client::Firefox, false) => &self.firefox,
            (Client::Firefox, true) => &self.firefox_main,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn h(text: &str) -> SampleTime {
        text.parse().expect("a sample time")
    }

    #[test]
    fn the_built_in_ones_are_whole() {
        let timings = Timings::built_in().expect("built in");
        let median_ns = |rates: &Rates| rates.near(h("3ms")).up_ns.median_ns();
        assert!(median_ns(&timings.native) < median_ns(&timings.python));
        // HTML has it that timers within timers wait at least 4 ms.
        for main in [&timings.chromium_main, &timings.firefox_main] {
            assert!((3_500_000..5_000_000).contains(&main.near(h("3ms")).clamp_ns));
        }
    }

    #[test]
    fn a_rate_that_was_not_measured_has_the_times_of_the_one_next_to_it_by_ratio() {
        let timing = |ns| Timing {
            serve_ns: ns,
            ..Timing::IDEAL
        };
        let rates = Rates::try_from(BTreeMap::from([
            (h("1ms"), timing(1)),
            (h("10ms"), timing(10)),
        ]))
        .expect("two rates");
        for (text, ns) in [
            ("10us", 1),
            ("1ms", 1),
            ("3ms", 1),
            ("4ms", 10),
            ("10ms", 10),
            ("1s", 10),
        ] {
            assert_eq!(rates.near(h(text)).serve_ns, ns, "{text}");
        }
        assert!(Rates::try_from(BTreeMap::new()).is_err());
    }
}
