//! The answer in sentences.

use std::collections::BTreeSet;

use plan::Client;

use super::{Answer, Row, Standing, Survival};
use crate::number::{duration, significant, spelled};

/// The most loops that are named; further ones are only counted.
const NAMED: usize = 4;

impl Answer {
    /// The answer in sentences. The first is a summary of all.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        [
            Some(self.headline()),
            self.simulated
                .then(|| "All runs are simulated, in virtual time.".to_owned()),
            self.exceptions(),
            self.settling(),
            Some(self.coverage.words()),
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

    fn headline(&self) -> String {
        let runs = |figure: fn(&Standing) -> usize| -> usize {
            self.loops().map(|(_, _, standing)| figure(standing)).sum()
        };
        let Some(survival) = self.survival() else {
            return "No loop was closed: this experiment has open loops only.".to_owned();
        };
        match survival {
            Survival::Unknown => {
                let planned = runs(|standing| standing.planned);
                return match planned {
                    1 => "Whether the loop survives is not known: its one run is not complete."
                        .to_owned(),
                    _ => format!(
                        "Whether the loop survives is not known: none of {planned} runs is complete."
                    ),
                };
            }
            Survival::Never => {
                let complete = runs(|standing| standing.complete);
                return match complete {
                    1 => {
                        "The loop does not survive: the one complete run is not stable.".to_owned()
                    }
                    _ => format!(
                        "The loop does not survive: none of {complete} complete runs is stable."
                    ),
                };
            }
            Survival::Always | Survival::Sometimes => {}
        }
        let is_partial = self
            .loops()
            .any(|(_, _, standing)| standing.survival() == Survival::Unknown);
        let opening = if is_partial {
            "As far as it was run, the loop survives"
        } else {
            "The loop survives"
        };
        let places = self.places();
        if places.is_empty() {
            return format!("{opening} in some runs only: no client keeps it stable in all.");
        }
        let but = self.elsewhere();
        if but.is_empty() {
            format!("{opening} {}.", listed(&places))
        } else {
            format!("{opening} {}, but {}.", listed(&places), listed(&but))
        }
    }

    /// Where the loop does not always survive: `not always on couva`, or, if this is not so for all
    /// clients, `never with Chromium on arima`.
    fn elsewhere(&self) -> Vec<String> {
        let mut places = Vec::new();
        for topology in &self.topologies {
            let of = |client: &Client| Some((*client, self.survival_of(*client, topology)?));
            let clients: Vec<(Client, Survival)> = self.clients().iter().filter_map(of).collect();
            for (survival, how) in [
                (Survival::Sometimes, "not always"),
                (Survival::Never, "never"),
            ] {
                let such: Vec<&str> = clients
                    .iter()
                    .filter(|(_, own)| *own == survival)
                    .map(|(client, _)| client.prose())
                    .collect();
                match such.len() {
                    0 => {}
                    n if n == clients.len() => places.push(format!("{how} on {topology}")),
                    _ => places.push(format!("{how} with {} on {topology}", listed(&such))),
                }
            }
        }
        places
    }

    /// The clients of the runs, webloop's first.
    fn clients(&self) -> Vec<Client> {
        let all: BTreeSet<Client> = self.rows.iter().map(|row| row.client).collect();
        all.into_iter().collect()
    }

    /// Whether a client keeps the loop stable on a topology, at all rates and in all setups; `None`
    /// without a complete run.
    fn survival_of(&self, client: Client, topology: &str) -> Option<Survival> {
        let own = self
            .loops()
            .filter(|(row, place, _)| row.client == client && *place == topology);
        let survival = all_of(own.map(|(_, _, standing)| standing))?;
        Some(survival).filter(|survival| *survival != Survival::Unknown)
    }
    /// `on all five topologies with native and Python`: for each client, the topologies on which
    /// every complete run is stable, at every rate and in every setup. Clients with the same
    /// topologies are joined.
    fn places(&self) -> Vec<String> {
        let mut together: Vec<(Vec<&str>, Vec<Client>)> = Vec::new();
        for client in self.clients() {
            let topologies: Vec<&str> = self
                .topologies
                .iter()
                .map(String::as_str)
                .filter(|topology| self.survival_of(client, topology) == Some(Survival::Always))
                .collect();
            if topologies.is_empty() {
                continue;
            }
            match together.iter_mut().find(|(same, _)| *same == topologies) {
                Some((_, clients)) => clients.push(client),
                None => together.push((topologies, vec![client])),
            }
        }
        let part = |(topologies, clients): &(Vec<&str>, Vec<Client>)| {
            let clients: Vec<&str> = clients.iter().map(Client::prose).collect();
            format!("{} with {}", self.on(topologies), listed(&clients))
        };
        together.iter().map(part).collect()
    }

    /// `on all five topologies`, `on arima and couva`.
    fn on(&self, topologies: &[&str]) -> String {
        let all = topologies.len() == self.topologies.len();
        match (topologies.len(), all) {
            (2, true) => format!("on both topologies, {},", listed(topologies)),
            (n @ 3.., true) => format!("on all {} topologies", spelled(n as f64)),
            _ => format!("on {}", listed(topologies)),
        }
    }

    /// The loops that do not always survive; `None` unless others do.
    fn exceptions(&self) -> Option<String> {
        if self.survival() != Some(Survival::Sometimes) {
            return None;
        }
        let failing: Vec<String> = self
            .loops()
            .filter(|(_, _, standing)| {
                matches!(standing.survival(), Survival::Sometimes | Survival::Never)
            })
            .map(|(row, topology, standing)| {
                let Standing {
                    stable, complete, ..
                } = standing;
                let loop_ = self.named(row, topology);
                match (stable, complete) {
                    (0, 1) => format!("{loop_} (its one run is not stable)"),
                    (0, _) => format!("{loop_} (none of {complete} runs stable)"),
                    _ => format!("{loop_} ({stable} of {complete} runs stable)"),
                }
            })
            .collect();
        let mut named: Vec<String> = failing.iter().take(NAMED).cloned().collect();
        if failing.len() > NAMED {
            named.push(format!("{} more", spelled((failing.len() - NAMED) as f64)));
        }
        Some(format!("It does not always survive {}.", listed(&named)))
    }

    /// `with Chromium (paper-2011) on arima at 333 Hz`.
    fn named(&self, row: &Row, topology: &str) -> String {
        let same = |other: &&Row| other.client == row.client && other.setup != row.setup;
        let setup = if self.rows.iter().any(|other| same(&other)) || !row.is_usual() {
            format!(" ({})", row.setup)
        } else {
            String::new()
        };
        let client = row.client.prose();
        format!("with {client}{setup} on {topology} at {}", row.rate)
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
        if settled.len() == 1 {
            return Some(format!("In the median it settles in {fast}."));
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

/// Whether several loops survive, taken together; `None` if there are none.
fn all_of<'a>(standings: impl Iterator<Item = &'a Standing>) -> Option<Survival> {
    let sum = standings.fold(None, |sum: Option<Standing>, standing| {
        let sum = sum.unwrap_or_default();
        Some(Standing {
            complete: sum.complete + standing.complete,
            stable: sum.stable + standing.stable,
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
