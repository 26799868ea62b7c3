//! Measured times that each client and its plant take for messages, for virtual time.

use std::collections::{BTreeMap, BTreeSet};

use endpoint::{SampleTime, Thread};
use plan::{Cell, Client};
use serde::{Deserialize, Serialize};
use sim::Timing;
use text::TomlText;

/// Measured on the machine that webloop is built on; `webloop calibrate` measures on yours.
const BUILT_IN: &str = include_str!("timings.toml");

/// A program that is timed: a client and, if it is a page, its thread.
pub type TimedProgram = (Client, Option<Thread>);

/// How long each client takes, at each measured sample time, by its name: `firefox` is its page in a
/// worker, and `firefox-main` its page on the main thread, with `setTimeout`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Timings(BTreeMap<String, Rates>);

/// A [`Timing`] for each measured sample time: a program that sends rarely sleeps in between, and wakes
/// more slowly.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    try_from = "BTreeMap<SampleTime, Timing>",
    into = "BTreeMap<SampleTime, Timing>"
)]
pub struct Rates(BTreeMap<SampleTime, Timing>);

impl Rates {
    /// The timing of the measured sample time nearest to `h`, by ratio.
    #[must_use]
    pub fn near(&self, h: SampleTime) -> &Timing {
        let slower = self.0.range(h..).next();
        let faster = self.0.range(..h).next_back();
        match (faster, slower) {
            (Some((_, only)), None) | (None, Some((_, only))) => only,
            (Some((below, timing)), Some((above, other))) => {
                // h/below < above/h, without a division.
                let square = u128::from(h.ns()) * u128::from(h.ns());
                if square < u128::from(below.ns()) * u128::from(above.ns()) {
                    timing
                } else {
                    other
                }
            }
            (None, None) => &Timing::IDEAL,
        }
    }
}

impl TryFrom<BTreeMap<SampleTime, Timing>> for Rates {
    type Error = &'static str;

    fn try_from(rates: BTreeMap<SampleTime, Timing>) -> Result<Self, Self::Error> {
        if rates.is_empty() {
            Err("a client needs timings for at least one sample time")
        } else {
            Ok(Self(rates))
        }
    }
}

impl From<Rates> for BTreeMap<SampleTime, Timing> {
    fn from(rates: Rates) -> Self {
        rates.0
    }
}

/// Why a text does not hold timings.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidTimings(String);

impl Timings {
    /// The timings that the binary carries.
    ///
    /// # Errors
    /// Never, as a test shows.
    pub fn built_in() -> Result<Timings, InvalidTimings> {
        Timings::read(BUILT_IN)
    }

    /// Reads timings from a TOML text, as `webloop calibrate` writes it.
    ///
    /// # Errors
    /// What is wrong, with line and column, or which program is missing or unknown.
    pub fn read(text: &str) -> Result<Timings, InvalidTimings> {
        let text = TomlText { text, origin: "" };
        let read = text.read("`webloop calibrate` writes such a file");
        let rates: BTreeMap<String, Rates> =
            read.map_err(|unread| InvalidTimings(unread.to_string()))?;
        let asked: BTreeSet<String> = programs().map(name).collect();
        let given: BTreeSet<String> = rates.keys().cloned().collect();
        match asked.symmetric_difference(&given).next() {
            Some(name) if given.contains(name) => {
                Err(format!("unknown client `{name}` in the timings"))
            }
            Some(name) => Err(format!("the timings of `{name}` are missing")),
            None => Ok(Timings(rates)),
        }
        .map_err(InvalidTimings)
    }

    /// The timings as a TOML text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        const HEAD: &str = "\
# How long programs take over a message, in ns, as measured: one number, or the quantiles from 0 to 1
# in steps of 1/32. What each is, is in orchestrator/sim/src/timing.rs.
";
        let section = |program| {
            let rates = BTreeMap::from([(name(program), self.rates(program))]);
            // Plain data of numbers: serialising it cannot fail.
            toml::to_string(&rates).unwrap_or_default()
        };
        HEAD.to_owned() + &programs().map(section).collect::<Vec<_>>().join("\n")
    }

    /// The timings that `rates` finds for each program.
    ///
    /// # Errors
    /// The error of `rates`.
    pub fn found<E>(rates: impl Fn(TimedProgram) -> Result<Rates, E>) -> Result<Timings, E> {
        let found = programs().map(|program| Ok((name(program), rates(program)?)));
        found.collect::<Result<_, E>>().map(Timings)
    }

    /// The timing of a cell's client, at its sample time.
    #[must_use]
    pub fn of(&self, cell: &Cell) -> &Timing {
        let program = (cell.client, cell.page.map(|page| page.thread));
        self.rates(program).near(cell.settings.h)
    }

    /// The timings of a program.
    #[must_use]
    pub fn rates(&self, program: TimedProgram) -> &Rates {
        &self.0[&name(program)]
    }
}

/// All programs, in the order of the file.
fn programs() -> impl Iterator<Item = TimedProgram> {
    let of = |client: Client| {
        if client.is_browser() {
            vec![(client, Some(Thread::Worker)), (client, Some(Thread::Main))]
        } else {
            vec![(client, None)]
        }
    };
    Client::ALL.into_iter().flat_map(of)
}

/// The program's name in the file.
fn name((client, thread): TimedProgram) -> String {
    match thread {
        Some(Thread::Main) => format!("{client}-main"),
        Some(Thread::Worker) | None => client.to_string(),
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
        let near = |client, thread| timings.rates((client, thread)).near(h("3ms"));
        let median_ns = |client| near(client, None).up_ns.median_ns();
        assert!(median_ns(Client::Native) < median_ns(Client::Python));
        // By the HTML standard, timers within timers wait at least 4 ms.
        for client in [Client::Chromium, Client::Firefox] {
            let main = near(client, Some(Thread::Main));
            assert!((3_500_000..5_000_000).contains(&main.clamp_ns));
        }
        // The file leaves out the rate of the kernel's timers, which is the usual one.
        assert_eq!(timings.to_toml().replace("hz = 250\n", ""), BUILT_IN);
        let other = Timings::read(&BUILT_IN.replace("[python.", "[lynx."));
        assert!(other.is_err_and(|problem| problem.0.contains("unknown client `lynx`")));
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
