//! The longest constant round trip at which a loop is stable: as `control` computes it, and as the
//! sweep found it.

use std::collections::BTreeMap;

use control::{Analysis, largest_stable_blocking_round_trip_s};
use endpoint::Outstanding;

use super::runs::PointRuns;
use plan::sweep::{Axis, Between, Point, Sweep};

const MS_PER_S: f64 = 1e3;

/// The longest stable round trip of a point's loop by analysis, whatever its own link is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Analysis has no answer: it covers one request under way or any number of them, but not a few;
    /// or the loop depends on too many past ticks, or its figures cannot be known to three digits; or its law
    /// measures how old outputs are.
    Unknown,
    /// The loop is unstable even at the shortest round trip.
    None,
    /// The loop is stable up to this round trip, ms, and at every shorter one; infinite if at all.
    Until(f64),
}

/// Where a sweep's loops become unstable along the round trip, all else being equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// The place of the point with the shortest round trip.
    pub place: Vec<usize>,
    /// The computed limit.
    pub limit: Limit,
    /// The longest round trip, ms, at which all runs were stable, as at every shorter one.
    pub found_ms: Option<f64>,
    /// The shortest round trip, ms, at which a run was unstable; `None` if there is none.
    pub lost_ms: Option<f64>,
    /// Whether every round trip is the same, so that the analysis holds for this link.
    pub is_constant: bool,
    /// One sample, ms: the permitted difference between the two.
    pub h_ms: f64,
}

impl Border {
    /// How far the computed limit lies outside the range that the sweep leaves open, ms; `None` if
    /// there is nothing to compare.
    #[must_use]
    pub fn off_ms(&self) -> Option<f64> {
        let limit_ms = match self.limit {
            Limit::Unknown => return None,
            Limit::None => -self.h_ms,
            Limit::Until(ms) => ms,
        };
        let below = self.found_ms.map_or(0.0, |found| found - limit_ms);
        let above = self.lost_ms.map_or(0.0, |lost| limit_ms - lost);
        self.is_constant.then_some(below.max(above).max(0.0))
    }

    /// Whether the two differ by at most one sample.
    #[must_use]
    pub fn agrees(&self) -> Option<bool> {
        // For sums of numbers in ms, each of which was rounded once.
        const ROUNDING_MS: f64 = 1e-6;
        self.off_ms()
            .map(|off_ms| off_ms <= self.h_ms + ROUNDING_MS)
    }
}

/// The longest stable round trip of a point's loop by analysis.
#[must_use]
pub fn limit(point: &Point) -> Limit {
    let Ok(own) = point.design() else {
        return Limit::Unknown;
    };
    if own.law.measures_age() {
        return Limit::Unknown;
    }
    let told = match point.outstanding {
        Outstanding::Unlimited => own
            .open()
            .ok()
            .and_then(|own| Analysis::of(&own).ok())
            .map(|found| found.longest_s),
        Outstanding::ONE => largest_stable_blocking_round_trip_s(&own.plant, &own.law).ok(),
        Outstanding::Limited(_) => None,
    };
    match told {
        None => Limit::Unknown,
        Some(None) => Limit::None,
        Some(Some(s)) => Limit::Until(s * MS_PER_S),
    }
}

/// The borders of a sweep with several round trips; empty for others.
#[must_use]
pub fn borders(sweep: &Sweep, points: &[PointRuns]) -> Vec<Border> {
    let dimensions = sweep.grid.dimensions();
    let rtt = dimensions.iter().position(|d| d.axis == Axis::Rtt);
    let Some(rtt) = rtt.filter(|at| dimensions[*at].levels.len() > 1) else {
        return Vec::new();
    };
    let mut rtts: Vec<(f64, usize)> = dimensions[rtt]
        .levels
        .iter()
        .enumerate()
        .filter_map(|(at, level)| Some((level.number?, at)))
        .collect();
    rtts.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The computed limit does not depend on the link, and takes longer to compute than a run.
    let mut known: BTreeMap<Vec<usize>, Limit> = BTreeMap::new();
    let first = rtts.first().map_or(0, |(_, at)| *at);
    let places = (0..sweep.grid.points()).map(|number| sweep.grid.place(number));
    places
        .filter(|place| place[rtt] == first)
        .map(|place| {
            let point = sweep.grid.point(sweep.grid.number(&place));
            let of_loop: Vec<usize> = dimensions
                .iter()
                .zip(&place)
                .filter(|(d, _)| d.axis >= Axis::System)
                .map(|(_, at)| *at)
                .collect();
            let limit = *known.entry(of_loop).or_insert_with(|| limit(&point));
            let mut border = Border {
                limit,
                found_ms: None,
                lost_ms: None,
                is_constant: matches!(&point.between, Between::Made(made) if made.is_constant()),
                h_ms: point.h.seconds() * MS_PER_S,
                place: place.clone(),
            };
            for (rtt_ms, at) in &rtts {
                let mut there = place.clone();
                there[rtt] = *at;
                let runs = points.get(sweep.grid.number(&there));
                if runs.is_none_or(|runs| runs.stable < runs.runs) {
                    border.lost_ms = Some(*rtt_ms);
                    break;
                }
                border.found_ms = Some(*rtt_ms);
            }
            border
        })
        .collect()
}
