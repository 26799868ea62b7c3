//! The answer in sentences.

use analysis::LoopVerdict;
use plan::{Client, Setup};
use text::significant;

use super::{Answer, Row, Standing, Survival};
use crate::number::{duration, spelled};

/// The most loops that are named; further ones are only counted.
const NAMED: usize = 4;

impl Answer {
    /// The answer in sentences. The first is a summary of all.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        [
            Some(self.headline()),
            self.simulated.then(|| match self.is_one_run() {
                true => "The run is simulated, in virtual time.".to_owned(),
                false => "All runs are simulated, in virtual time.".to_owned(),
            }),
            self.exceptions(),
            self.settling(),
            // Of one run the rest says so.
            (!self.is_one_run()).then(|| self.coverage.words()),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Whether the loop survives, over all clients and topologies; `None` if the plan closes no loop.
    #[must_use]
    pub fn survival(&self) -> Option<Survival> {
        all_of(self.loops().map(|(_, _, standing)| standing))
    }

    /// Whether one complete run of a closed loop is all that was planned.
    fn is_one_run(&self) -> bool {
        self.coverage.planned() == 1 && self.complete() == 1
    }

    /// The loops that do not always hold, each with the worst that happened to it; `None` if all do.
    fn exceptions(&self) -> Option<String> {
        if self.is_one_run() {
            let (_, _, standing) = self.loops().next()?;
            let (verdict, reason) = standing.worst.as_ref()?;
            let reason = reason.as_deref();
            return Some(match reason {
                Some(reason) => format!("It {}: {reason}.", said(*verdict)),
                None => format!("It {}.", said(*verdict)),
            });
        }
        let failing: Vec<String> = self
            .loops()
            .filter_map(|(row, topology, standing)| {
                let (verdict, reason) = standing.worst.as_ref()?;
                let reason = reason
                    .as_deref()
                    .map_or_else(String::new, |of| format!(" ({of})"));
                let Standing {
                    holds, complete, ..
                } = standing;
                let count = match (holds, complete) {
                    (_, 1) => String::new(),
                    (0, _) => format!("none of {complete}, at worst "),
                    _ => format!("{holds} of {complete}, at worst "),
                };
                let named = self.named(row, topology);
                Some(format!("{named}: {count}{verdict}{reason}"))
            })
            .collect();
        if failing.is_empty() {
            return None;
        }
        let mut named: Vec<String> = failing.iter().take(NAMED).cloned().collect();
        if failing.len() > NAMED {
            named.push(format!("{} more", spelled((failing.len() - NAMED) as f64)));
        }
        Some(format!("Not always well {}.", named.join("; ")))
    }

    /// `with Chromium (paper-2011) on arima at 333 Hz`; without what all loops have in common.
    fn named(&self, row: &Row, topology: &str) -> String {
        let setup = match self.unlike(row) {
            words if words.is_empty() => String::new(),
            words => format!(" ({words})"),
        };
        let rate = if self.rows.iter().any(|other| other.h_ns != row.h_ns) {
            format!(" at {}", row.rate)
        } else {
            String::new()
        };
        let client = row.client.prose();
        format!("with {client}{setup} on {topology}{rate}")
    }

    /// What a row's setup has that not all setups of its client have. A browser's is named whole.
    fn unlike(&self, row: &Row) -> Setup {
        if row.client.is_browser() && !row.is_plain {
            return row.setup.clone();
        }
        let same = self.rows.iter().filter(|other| other.client == row.client);
        let setups: Vec<&Setup> = same.map(|other| &other.setup).collect();
        row.setup.apart_from(&setups)
    }

    /// Median settling, from the fastest loop to the slowest.
    fn settling(&self) -> Option<String> {
        let mut settled: Vec<(f64, &Row, &str, &Standing)> = self
            .loops()
            .filter_map(|(row, topology, standing)| {
                Some((standing.settling_ms?.value, row, topology, standing))
            })
            .collect();
        settled.sort_by(|one, other| one.0.total_cmp(&other.0));
        let (fastest, row, topology, _) = *settled.first()?;
        let fast = format!("{} {}", duration(fastest), self.named(row, topology));
        let (slowest, row, topology, standing) = *settled.last()?;
        if self.is_one_run() {
            return Some(format!("It settles in {}.", duration(fastest)));
        }
        if settled.len() == 1 {
            return Some(format!("In the median it settles in {fast}."));
        }
        if duration(fastest) == duration(slowest) {
            return Some(format!(
                "In the median all settle in {}.",
                duration(slowest)
            ));
        }
        let slow = format!("{} {}", duration(slowest), self.named(row, topology));
        // Python is the paper's yardstick; native is used where Python was not run.
        let times = standing.times.iter().max_by_key(|times| times.of);
        let times = match (times, &self.reference) {
            (Some(times), Some(reference)) => format!(
                ", {} times {} on {reference} at that rate",
                significant(times.factor, 2),
                match times.of {
                    Client::Native => "the native client’s".to_owned(),
                    client => format!("{}’s", client.prose()),
                }
            ),
            _ => String::new(),
        };
        Some(format!(
            "Median settling is between {fast} and {slow}{times}."
        ))
    }
}

/// A verdict as what a loop does or is.
fn said(verdict: LoopVerdict) -> String {
    match verdict {
        LoopVerdict::Silent | LoopVerdict::Lost => format!("is {verdict}"),
        _ => verdict.to_string(),
    }
}

/// Whether several loops survive, taken together; `None` if there are none.
fn all_of<'a>(standings: impl Iterator<Item = &'a Standing>) -> Option<Survival> {
    let sum = standings.fold(None, |sum: Option<Standing>, standing| {
        let sum = sum.unwrap_or_default();
        Some(Standing {
            complete: sum.complete + standing.complete,
            holds: sum.holds + standing.holds,
            ..sum
        })
    });
    sum.map(|sum| sum.survival())
}

/// `a`, `a and b`, `a, b and c`; if a part contains an `and`, `a and b, and c`.
pub(super) fn listed<S: AsRef<str>>(parts: &[S]) -> String {
    let parts: Vec<&str> = parts.iter().map(AsRef::as_ref).collect();
    let and = if parts.iter().any(|part| part.contains(" and ")) {
        ", and "
    } else {
        " and "
    };
    match parts.split_last() {
        None => String::new(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, before)) => format!("{}{and}{last}", before.join(", ")),
    }
}
