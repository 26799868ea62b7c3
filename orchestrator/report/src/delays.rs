//! The delays of a campaign's runs, pooled over the runs that share a link and a client: how long round
//! trips, ways and lateness were, and the parts of a sample's delay.
//!
//! The system makes no difference to a delay, so runs of several systems are pooled.

mod label;
mod nearest;

use std::collections::BTreeMap;

use analysis::blame::Blame;
use analysis::budget::{self, Budget, Part};
use analysis::statistics::upper_median;
use analysis::trace::Response;
use analysis::{Campaign, Run, grouped, parallel};
use chart::Tone;

use crate::tone::Tones;

use label::Names;
pub use nearest::{Nearest, nearest_to_failing};
use record::{Held, ReadError};

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
    /// What is to blame in it; known only of the run nearest to failing of the whole campaign.
    pub blame: Option<Blame>,
    /// The plant's output and input in it; known of the same run alone.
    pub response: Option<Response>,
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
    let mut groups: Vec<_> = groups.into_iter().collect();
    let topologies = grouped(&groups, |((topology, ..), _)| *topology);
    let order: Vec<&str> = topologies
        .into_iter()
        .map(|(topology, _)| topology)
        .collect();
    groups.sort_by_key(|((of, ..), _)| order.iter().position(|topology| topology == of));
    // The nearest of those that are the nearest of their loops.
    let worst = groups
        .iter()
        .filter_map(|(_, runs)| nearest_to_failing(runs.iter().copied()));
    let closed = worst.filter(|run| run.summary.loop_verdict.is_some());
    let nearest = nearest_to_failing(closed).map(|run| run.cell.index);
    let all = parallel::each(&groups, |((topology, client, label), runs)| {
        let tone = tones.tone(*client);
        Delays::of(
            campaign,
            topology,
            label.clone(),
            tone,
            runs.clone(),
            nearest,
        )
    });
    all.into_iter().filter_map(Result::transpose).collect()
}

impl<'a> Delays<'a> {
    /// `None` without a run. `nearest` is the index of the cell nearest to failing of the whole campaign.
    fn of(
        campaign: &Campaign,
        topology: &'a str,
        label: String,
        tone: Tone,
        runs: Vec<&'a Run>,
        nearest: Option<usize>,
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
            blame: None,
            response: None,
        };
        let mut medians: Vec<[i64; 8]> = Vec::new();
        let mut profiles = BTreeMap::new();
        for run in &runs {
            let profile = profiles
                .entry(&run.cell.fault)
                .or_insert_with(|| budget::profile(run, &campaign.plan));
            let link = profile.as_ref().and_then(|of| budget::timeline_of(run, of));
            let budget = if nearest == Some(run.cell.index) {
                // Its rows are read once for all.
                let rows = Held::read(&run.folder)?;
                delays.blame = Blame::by(&rows, run, &campaign.plan);
                delays.response = Some(Response::of(&rows.ticks, &run.lasts_ns()));
                Budget::by(&rows, run, link)
            } else {
                Budget::through(run, link)?
            };
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
            values.sort_unstable_by(f64::total_cmp);
        }
        delays.parts_ms = (!medians.is_empty())
            .then(|| Part::ALL.map(|part| median_ms(medians.iter().map(|of| of[part as usize]))));
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

/// What is told to programs that leave no stamps, behind a caption; empty if there are none.
#[must_use]
pub fn unstamped(delays: &[Delays<'_>]) -> String {
    let label = |of: &Delays<'_>| of.label.clone();
    let distinct = |mut labels: Vec<String>| {
        labels.sort();
        labels.dedup();
        labels.join("; ")
    };
    let own = || {
        delays
            .iter()
            .filter(|of| of.runs.iter().any(|run| run.cell.client.is_own()))
    };
    let silent = distinct(own().filter(|of| of.up_ms.is_empty()).map(label).collect());
    let half = own().filter(|of| !of.up_ms.is_empty() && of.round_trip_ms.is_empty());
    let half = distinct(half.map(label).collect());
    let mut words = String::new();
    if !silent.is_empty() {
        words += &format!(
            " Not shown: {silent}, whose messages do not say when they were sent. With seq and t_send_ns in each query \
             (docs/contract.md) their ways up and their lateness are here."
        );
    }
    if !half.is_empty() {
        words += &format!(
            " Of {half} only the way up and the lateness are known: who also leaves messages.csv in WEBLOOP_OUT has \
             round trips and the parts of a sample's delay."
        );
    }
    words
}

fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

fn median_ms(values: impl Iterator<Item = i64>) -> f64 {
    let mut values: Vec<i64> = values.collect();
    upper_median(&mut values, Ord::cmp).map_or(0.0, ms)
}
