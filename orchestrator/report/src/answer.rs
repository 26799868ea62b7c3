//! The answer: whether the loop survives, where, with which client, and at what rate.
//!
//! Computed from the closed loops alone; [`words`](Answer::words) gives it in sentences. What the
//! runs say about the paper is in [`claim`](crate::claim).

mod coverage;
mod headline;
mod words;

#[cfg(test)]
mod tests;

use analysis::{Campaign, LoopVerdict, Run, grouped};
use endpoint::Mode;
use plan::system::System;
use plan::{Client, Setup};

pub use coverage::Coverage;

use crate::called::{is_kept, kept};
use crate::group::{Estimate, Group};
use crate::outcome::OutcomeKind;

/// How the closed loops of a campaign ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The experiment's name.
    pub experiment: String,
    /// The topologies on which the plan closes a loop, in the order of the plan: the columns.
    pub topologies: Vec<String>,
    /// The topology without a network, with which others are compared; `None` if the plan closes no
    /// loop on one.
    pub reference: Option<String>,
    /// A row for each client, setup and rate.
    pub rows: Vec<Row>,
    /// How the runs of the whole campaign ended, including open loops.
    pub coverage: Coverage,
    /// Whether the runs are in virtual time.
    pub simulated: bool,
}

/// A client in one setup at one rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The client.
    pub client: Client,
    /// What it and its plant were set to.
    pub setup: Setup,
    /// The system.
    pub system: String,
    /// Whether the setup is the client's usual one, apart from the system.
    pub is_plain: bool,
    /// The rate for people: `333 Hz`.
    pub rate: String,
    /// The sample time, ns.
    pub h_ns: u64,
    /// How the loop ended on each topology, in their order; `None` if the plan does not have it there.
    pub standings: Vec<Option<Standing>>,
}

/// How the repeats of one loop ended.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Standing {
    /// Number of repeats in the plan.
    pub planned: usize,
    /// Number of complete repeats; only these are counted below.
    pub complete: usize,
    /// Those that hold, and hold well.
    pub holds: usize,
    /// How many have each verdict, in the order of [`LoopVerdict::ALL`].
    pub verdicts: [usize; LoopVerdict::ALL.len()],
    /// The worst verdict that is not the best, with its reason.
    pub worst: Option<(LoopVerdict, Option<String>)>,
    /// What the complete ones do, where all hold and none has a settling time; `None` otherwise.
    pub kept: Option<&'static str>,
    /// The median overshoot of the complete ones, % of the step; `None` where none holds or there is no step.
    pub overshoot_pct: Option<f64>,
    /// The greatest overshoot of those that hold, well or badly, % of the step; 0 without any.
    pub overshoot_most_pct: f64,
    /// How those ended that are not complete, and how many, in the order of [`OutcomeKind::ALL`].
    pub others: Vec<(OutcomeKind, usize)>,
    /// Median settling over the complete ones, ms; `None` if there are none, or half of them never
    /// settled.
    pub settling_ms: Option<Estimate>,
    /// That median relative to the medians of other loops.
    pub times: Vec<Times>,
}

/// Settling relative to that of a reference at the same rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    /// The client of the reference, which has the same system and its usual setup, and no network.
    pub of: Client,
    /// The median divided by that of the reference.
    pub factor: f64,
}

/// Whether a loop survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Survival {
    /// Every complete run holds.
    Always,
    /// Some complete runs hold.
    Sometimes,
    /// No complete run holds.
    Never,
    /// No run is complete.
    Unknown,
}

impl Answer {
    /// Counts the campaign's closed loops.
    #[must_use]
    pub fn of(campaign: &Campaign) -> Answer {
        let closed: Vec<&Run> = campaign
            .runs
            .iter()
            .filter(|run| run.cell.settings.mode == Mode::Closed)
            .collect();
        let mut topologies: Vec<String> = Vec::new();
        for run in &closed {
            if !topologies.contains(&run.cell.topology) {
                topologies.push(run.cell.topology.clone());
            }
        }
        let reference = topologies
            .iter()
            .find(|name| campaign.plan.is_loopback(name))
            .cloned();
        let mut rows = rows(&closed, &topologies);
        hold_against(&mut rows, &topologies, reference.as_deref());
        Answer {
            experiment: campaign.plan.experiment.clone(),
            topologies,
            reference,
            rows,
            coverage: Coverage::of(campaign),
            simulated: campaign.is_simulated(),
        }
    }

    /// Every loop of the plan, with its row and its topology.
    pub fn loops(&self) -> impl Iterator<Item = (&Row, &str, &Standing)> {
        self.rows.iter().flat_map(|row| {
            let places = self.topologies.iter().zip(&row.standings);
            places.filter_map(move |(topology, standing)| {
                Some((row, topology.as_str(), standing.as_ref()?))
            })
        })
    }
}

impl Row {
    /// Whether the setup is the client's usual one, with the paper's system.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        self.is_plain && self.system == System::PAPER
    }
}

impl Standing {
    /// Whether the loop survives.
    #[must_use]
    pub fn survival(&self) -> Survival {
        match (self.holds, self.complete) {
            (_, 0) => Survival::Unknown,
            (holds, complete) if holds == complete => Survival::Always,
            (0, _) => Survival::Never,
            _ => Survival::Sometimes,
        }
    }

    fn of(runs: &[&Run]) -> Standing {
        let group = Group::complete(runs.iter().copied());
        let count = |verdict| {
            let is = |run: &&&Run| run.summary.loop_verdict == Some(verdict);
            group.runs.iter().filter(is).count()
        };
        Standing {
            planned: group.planned,
            complete: group.runs.len(),
            holds: count(LoopVerdict::Holds),
            verdicts: LoopVerdict::ALL.map(count),
            worst: worst(&group),
            kept: kept_by(&group),
            overshoot_pct: group
                .median(|run| run.summary.overshoot_pct)
                .filter(|_| group.runs.iter().any(|run| is_held(run)))
                .map(|of| of.value),
            overshoot_most_pct: (group.runs.iter())
                .filter(|run| is_held(run))
                .filter_map(|run| run.summary.overshoot_pct)
                .fold(0.0, f64::max),
            others: others(runs),
            // What was in its band from the start has nothing to settle.
            settling_ms: group
                .settling_ms()
                .filter(|ms| ms.value.is_finite() && ms.value > 0.0),
            times: Vec::new(),
        }
    }
}

fn is_held(run: &Run) -> bool {
    run.summary.loop_verdict.is_some_and(LoopVerdict::is_held)
}

fn kept_by(group: &Group<'_>) -> Option<&'static str> {
    let first = group.runs.first()?;
    group
        .runs
        .iter()
        .all(|run| is_kept(run))
        .then(|| kept(first))
}

fn worst(group: &Group<'_>) -> Option<(LoopVerdict, Option<String>)> {
    let judged = group.runs.iter();
    let judged = judged.filter_map(|run| Some((run.summary.loop_verdict?, *run)));
    let worst = judged.max_by_key(|(verdict, _)| *verdict);
    let worst = worst.filter(|(verdict, _)| *verdict != LoopVerdict::Holds);
    worst.map(|(verdict, run)| (verdict, run.summary.loop_reason.clone()))
}

/// How runs ended that are not complete, and how many.
fn others(runs: &[&Run]) -> Vec<(OutcomeKind, usize)> {
    let count = |kind| {
        runs.iter()
            .filter(|run| OutcomeKind::of(run) == kind)
            .count()
    };
    let kinds = OutcomeKind::ALL.into_iter().map(|kind| (kind, count(kind)));
    kinds
        .filter(|(kind, count)| *kind != OutcomeKind::Complete && *count > 0)
        .collect()
}

/// The rows by client, then by setup in the order of the plan, then from the slowest rate to the
/// fastest.
fn rows(closed: &[&Run], topologies: &[String]) -> Vec<Row> {
    let mut setups = grouped(closed.iter().copied(), |run| {
        (run.cell.client, &run.summary.setup)
    });
    setups.sort_by_key(|((client, _), _)| *client);
    let mut rows = Vec::new();
    for ((client, setup), own) in setups {
        let cell = &own[0].cell;
        let mut rates: Vec<(u64, String)> = own
            .iter()
            .map(|run| (run.cell.settings.h.ns(), run.cell.rate()))
            .collect();
        rates.sort_by(|one, other| other.cmp(one));
        rates.dedup();
        for (h_ns, rate) in rates {
            let at = |topology: &String| {
                let is = |run: &&&Run| {
                    run.cell.topology == *topology && run.cell.settings.h.ns() == h_ns
                };
                let runs: Vec<&Run> = own.iter().filter(is).copied().collect();
                (!runs.is_empty()).then(|| Standing::of(&runs))
            };
            rows.push(Row {
                client,
                setup: setup.clone(),
                system: cell.system.clone(),
                is_plain: cell.is_plain(),
                rate,
                h_ns,
                standings: topologies.iter().map(at).collect(),
            });
        }
    }
    rows
}

/// Sets the settling of each loop relative to that of the yardsticks with the same system and without
/// a network.
fn hold_against(rows: &mut [Row], topologies: &[String], reference: Option<&str>) {
    let Some(column) = topologies
        .iter()
        .position(|topology| Some(topology.as_str()) == reference)
    else {
        return;
    };
    let references: Vec<(Client, String, u64, Estimate)> = rows
        .iter()
        .filter(|row| Client::YARDSTICKS.contains(&row.client) && row.is_plain)
        .filter_map(|row| {
            let settling_ms = row.standings.get(column)?.as_ref()?.settling_ms?;
            Some((row.client, row.system.clone(), row.h_ns, settling_ms))
        })
        .collect();
    for row in rows {
        for (at, standing) in row.standings.iter_mut().enumerate() {
            let Some(standing) = standing else { continue };
            let Some(own) = standing.settling_ms else {
                continue;
            };
            let times = references.iter().filter_map(|(client, system, h_ns, of)| {
                let is_itself = at == column && row.is_plain && row.client == *client;
                let is_like = *system == row.system && *h_ns == row.h_ns && !is_itself;
                let factor = own.times(*of).filter(|_| is_like)?.value;
                Some(Times {
                    of: *client,
                    factor,
                })
            });
            standing.times = times.collect();
        }
    }
}
