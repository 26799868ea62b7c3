//! The delays of a campaign's runs, pooled over the runs that share a link and a client: how long round
//! trips, ways and lateness were, and the parts of a sample's delay.
//!
//! The system makes no difference to a delay, so runs of several systems are pooled.

use std::collections::BTreeMap;

use analysis::budget::{self, Budget, Part};
use analysis::hold::{self, Hold};
use analysis::{Campaign, LoopVerdict, ReadError, Run, grouped, parallel};
use chart::Tone;
use endpoint::Mode;
use plan::Client;

use crate::tone::Tones;

/// The delays of the complete runs of one client with one setup at one rate over one topology.
#[derive(Debug, Clone)]
pub struct Delays<'a> {
    /// The topology.
    pub topology: &'a str,
    /// The client, with what tells its loops apart: `native, 333 Hz`, `firefox, worker`.
    pub label: String,
    /// The client's colour.
    pub tone: Tone,
    /// The runs.
    pub runs: Vec<&'a Run>,
    /// Round trips of messages, ms, sorted.
    pub round_trip_ms: Vec<f64>,
    /// Ways up, ms, sorted.
    pub up_ms: Vec<f64>,
    /// How late messages were sent, ms, sorted.
    pub late_ms: Vec<f64>,
    /// Delays of samples from measurement to effect, ms, sorted; none in open loop.
    pub sample_ms: Vec<f64>,
    /// The median over the runs of each part's median, ms, in the order of [`Part::ALL`].
    pub parts_ms: Option<[f64; 8]>,
    /// The run nearest to failing, with its messages.
    pub worst: (&'a Run, Budget),
}

/// The delays of a campaign: a value for each topology and loop, by topology, in the plan's order.
///
/// # Errors
/// [`ReadError`] if rows cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Delays<'_>>, ReadError> {
    let complete = campaign.runs.iter().filter(|run| run.is_complete());
    let complete: Vec<&Run> = complete.collect();
    let names = Names::of(&complete);
    let groups = grouped(complete.iter().copied(), |run| {
        (
            run.cell.topology.as_str(),
            run.cell.client,
            names.label(run),
        )
    });
    let tones = Tones::of(campaign);
    let groups: Vec<_> = groups.into_iter().collect();
    let all = parallel::each(&groups, |((topology, client, label), runs)| {
        let tone = tones.tone(*client);
        Delays::of(campaign, topology, label.clone(), tone, runs.clone())
    });
    let all: Result<Vec<_>, _> = all.into_iter().filter_map(Result::transpose).collect();
    let mut all = all?;
    let topologies = grouped(&all, |of| of.topology);
    let order: Vec<&str> = topologies
        .into_iter()
        .map(|(topology, _)| topology)
        .collect();
    all.sort_by_key(|of| order.iter().position(|topology| *topology == of.topology));
    Ok(all)
}

impl<'a> Delays<'a> {
    /// `None` without a run.
    fn of(
        campaign: &Campaign,
        topology: &'a str,
        label: String,
        tone: Tone,
        runs: Vec<&'a Run>,
    ) -> Result<Option<Delays<'a>>, ReadError> {
        let Some(worst) = nearest_to_failing(runs.iter().copied()) else {
            return Ok(None);
        };
        let mut delays = Delays {
            topology,
            label,
            tone,
            runs: Vec::new(),
            round_trip_ms: Vec::new(),
            up_ms: Vec::new(),
            late_ms: Vec::new(),
            sample_ms: Vec::new(),
            parts_ms: None,
            worst: (worst, Budget::default()),
        };
        let mut medians: Vec<[i64; 8]> = Vec::new();
        let mut profiles = BTreeMap::new();
        for run in &runs {
            let profile = profiles
                .entry(&run.cell.fault)
                .or_insert_with(|| budget::profile(run, &campaign.plan));
            let link = profile.as_ref().and_then(|of| budget::timeline_of(run, of));
            let budget = Budget::through(run, link)?;
            for trip in &budget.trips {
                delays.round_trip_ms.extend(trip.round_trip_ns().map(ms));
                delays.up_ms.push(ms(trip.up.ns()));
                delays.late_ms.push(ms(trip.client_ns()));
            }
            let samples = budget.samples.iter();
            delays
                .sample_ms
                .extend(samples.map(|sample| ms(sample.total_ns())));
            medians.extend(budget.medians_ns());
            if run.cell.index == worst.cell.index {
                delays.worst.1 = budget;
            }
        }
        delays.runs = runs;
        for values in [
            &mut delays.round_trip_ms,
            &mut delays.up_ms,
            &mut delays.late_ms,
            &mut delays.sample_ms,
        ] {
            values.sort_by(f64::total_cmp);
        }
        delays.parts_ms = (!medians.is_empty())
            .then(|| Part::ALL.map(|part| middle_ms(medians.iter().map(|of| of[part as usize]))));
        Ok(Some(delays))
    }

    /// Whether a run is among these.
    #[must_use]
    pub fn has(&self, run: &Run) -> bool {
        self.runs.iter().any(|one| one.cell.index == run.cell.index)
    }

    /// The median of the link's share of a sample's delay, ms; `None` in open loop.
    #[must_use]
    pub fn link_ms(&self) -> Option<f64> {
        let parts_ms = self.parts_ms?;
        let of_link = Part::ALL.into_iter().filter(|part| part.is_link());
        Some(of_link.map(|part| parts_ms[part as usize]).sum())
    }
}

/// The value below which this share of sorted values lies; `None` if there are too few of them for it, by the rule
/// of all tables: five beyond it, or luck decides.
#[must_use]
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    sorted
        .get(analysis::statistics::rank(sorted.len(), share)?)
        .copied()
}

/// The run nearest to failing: one whose loop failed, or the one that took the largest part of its time
/// to settle; among equals the one that went farthest.
pub fn nearest_to_failing<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<&'a Run> {
    runs.max_by(|one, other| {
        nearness(one)
            .partial_cmp(&nearness(other))
            .unwrap_or(std::cmp::Ordering::Equal)
    })
}

/// How near a run is to failing, by its verdict, its settling as a share of its length, and its overshoot.
fn nearness(run: &Run) -> (u8, f64, f64) {
    let summary = &run.summary;
    let verdict = match summary.loop_verdict {
        None => 0,
        Some(LoopVerdict::Stable) => 1,
        Some(LoopVerdict::NotSettled) => 2,
        Some(LoopVerdict::Unstable) => 3,
    };
    let length_ms = run.cell.duration_ns as f64 / 1e6;
    let settled = summary.settling_ms.unwrap_or(0.0) / length_ms;
    (verdict, settled, summary.overshoot_pct.unwrap_or(0.0))
}

/// The run of a campaign nearest to failing, and what hurt it.
#[derive(Debug, Clone)]
pub struct Nearest<'a> {
    /// The run.
    pub run: &'a Run,
    /// Its messages.
    pub budget: &'a Budget,
    /// The moment that hurt it; `None` if none stands out.
    pub hold: Option<Hold>,
}

impl<'a> Nearest<'a> {
    /// Among the complete closed loops; `None` without one.
    ///
    /// # Errors
    /// [`ReadError`] if rows cannot be read.
    pub fn of(
        campaign: &Campaign,
        delays: &'a [Delays<'a>],
    ) -> Result<Option<Nearest<'a>>, ReadError> {
        // It is the nearest of those that are the nearest of their loops.
        let closed = delays.iter().map(|of| of.worst.0);
        let closed = closed.filter(|run| run.summary.loop_verdict.is_some());
        let nearest = nearest_to_failing(closed);
        let of = nearest.and_then(|run| delays.iter().find(|of| of.worst.0.cell.id == run.cell.id));
        let Some((run, budget)) = of.map(|of| &of.worst) else {
            return Ok(None);
        };
        let hold = hold::worst(run, &campaign.plan, budget)?;
        Ok(Some(Nearest { run, budget, hold }))
    }
}

fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

fn middle_ms(values: impl Iterator<Item = i64>) -> f64 {
    let mut values: Vec<i64> = values.collect();
    values.sort_unstable();
    values.get(values.len() / 2).map_or(0.0, |ns| ms(*ns))
}

/// What has to be named to tell the loops of a campaign apart.
struct Names {
    /// The clients with more than one setup.
    setup: Vec<Client>,
    /// Whether open and closed loops are both there.
    mode: bool,
    /// Whether there are several rates.
    rate: bool,
}

impl Names {
    fn of(runs: &[&Run]) -> Names {
        let clients = grouped(runs.iter(), |run| run.cell.client);
        let several = clients.iter().filter(|(_, runs)| {
            grouped(runs.iter(), |run| run.cell.setup_beside_system()).len() > 1
        });
        Names {
            setup: several.map(|(client, _)| *client).collect(),
            mode: grouped(runs.iter(), |run| run.cell.settings.mode).len() > 1,
            rate: grouped(runs.iter(), |run| run.cell.settings.h.ns()).len() > 1,
        }
    }

    fn label(&self, run: &Run) -> String {
        let cell = &run.cell;
        let mut words = vec![cell.client.to_string()];
        if self.setup.contains(&cell.client) {
            words.push(cell.setup_beside_system());
        }
        if self.mode && cell.settings.mode == Mode::Open {
            words.push("open".to_owned());
        }
        if self.rate {
            words.push(cell.rate());
        }
        words.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many as decide that a percentile is not exceeded with 99 % confidence: 459 for the 99th, as `MLPerf` counts.
    #[test]
    fn a_percentile_needs_the_values_that_vouch_for_it() {
        let values: Vec<f64> = (1..=10_000).map(f64::from).collect();
        for (share, least) in [(0.5_f64, 10), (0.9, 50), (0.99, 500), (0.999, 5_000)] {
            let vouching = (0.01_f64.ln() / share.ln()).ceil() as usize;
            assert!(least >= vouching, "{share}: {vouching}");
            assert_eq!(percentile(&values[..least - 1], share), None, "{share}");
            let value = percentile(&values[..least], share);
            assert_eq!(value, Some((least as f64 * share).ceil()), "{share}");
        }
        assert_eq!(percentile(&[], 0.5), None);
    }
}
