//! Figure C: how long messages took, as the share that took longer, so that rare delays can be read.

use analysis::statistics::percentile;
use chart::{Guide, GuideAt, Mark, Panel, Scale, Series};

use super::scale::{Which, share};
use super::{Figure, panel};
use crate::delays::{Delays, unstamped};
use crate::number::duration;
use crate::origin::Origin;

/// The most points of a curve; the tail has all of its values.
const POINTS: usize = 120;
/// The values at the far end that are all drawn.
const TAIL: usize = 30;

/// The values of a curve, ms, sorted.
type Values = for<'a, 'b> fn(&'a Delays<'b>) -> &'a [f64];

/// What a column of panels shows.
const COLUMNS: [(&str, Values); 4] = [
    ("round trip", |of| &of.round_trip_ms),
    ("way up", |of| &of.up_ms),
    ("sent late by", |of| &of.late_ms),
    ("measurement to effect", |of| &of.sample_ms),
];

/// A row of panels for each topology. `None` without a message.
pub(super) fn figure(delays: &[Delays<'_>], campaign: &analysis::Campaign) -> Option<Figure> {
    let mut topologies: Vec<&str> = delays.iter().map(|of| of.topology).collect();
    topologies.dedup();
    // A column that one topology cannot fill is left out, so that there is no empty panel.
    let fills = |topology: &str, values: Values| {
        delays
            .iter()
            .any(|of| of.topology == topology && values(of).last().is_some_and(|most| *most > 0.0))
    };
    let columns: Vec<_> = COLUMNS
        .into_iter()
        .filter(|(_, values)| topologies.iter().all(|topology| fills(topology, *values)))
        .collect();
    if topologies.is_empty() || columns.is_empty() {
        return None;
    }
    let (mut origin, mut panels, mut sentences) = (Origin::default(), Vec::new(), Vec::new());
    for topology in topologies {
        let here: Vec<&Delays<'_>> = delays.iter().filter(|of| of.topology == topology).collect();
        for of in &here {
            origin.take(&of.runs);
        }
        for (name, values) in &columns {
            let panel = draw(&format!("{topology}, {name}"), &here, *values);
            let curves = here
                .iter()
                .map(|of| format!("{} {}", of.label, quantiles(values(of))));
            let curves: Vec<String> = curves.collect();
            sentences.push(format!("{}: {}.", panel.title, curves.join("; ")));
            panels.push(panel);
        }
    }
    for column in 0..columns.len() {
        let places: Vec<usize> = (column..panels.len()).step_by(columns.len()).collect();
        share(&mut panels, Which::X, &places);
        share(&mut panels, Which::Y, &places);
    }
    let mut figure = Figure::new(
        "C",
        "How long messages took",
        columns.len(),
        "Share of messages that took longer than a time, all repeats together; both scales are logarithmic. Half \
         of them take longer than p50, one of a hundred longer than p99. A curve ends at its longest message; \
         a percentile that is said has five messages beyond it: p99 needs 500, p99.9 needs 5000. The table of delays has the numbers. Measurement to effect: from the tick at which y was measured to the tick at which the u that follows from \
         it took effect. Panels of a column have the same axes, unless they differ tenfold.",
        None,
    );
    figure.caption += &unstamped(delays);
    Some(figure.drawn(panels, &sentences, &origin, campaign))
}

fn draw(title: &str, here: &[&Delays<'_>], values: Values) -> Panel {
    let mut panel = panel("", title, "time/ms", "take longer/%");
    panel.x.scale = Scale::Log;
    panel.y.scale = Scale::Log;
    for of in here {
        let sorted = values(of);
        let points = longer(sorted);
        if points.is_empty() {
            continue;
        }
        panel
            .series
            .push(Series::new(of.label.clone(), Mark::Line, of.tone, points));
    }
    let most = here.iter().map(|of| values(of).len()).max().unwrap_or(0);
    panel.y.range = Some((50.0 / most.max(2) as f64, 100.0));
    panel.guides = [("p50", 50.0), ("p90", 10.0), ("p99", 1.0), ("p99.9", 0.1)]
        .into_iter()
        .filter(|(_, percent)| most as f64 * percent / 100.0 >= 1.0)
        .map(|(name, percent)| Guide {
            name: name.to_owned(),
            at: GuideAt::Y(percent),
        })
        .collect();
    panel
}

/// `p50 0.914 ms, p99 3.20 ms, n 5998`, as far as there are enough values.
fn quantiles(sorted: &[f64]) -> String {
    let words = [("p50", 0.5), ("p99", 0.99)]
        .into_iter()
        .filter_map(|(name, share)| {
            Some(format!("{name} {}", duration(percentile(sorted, share)?)))
        });
    let words: Vec<String> = words.chain([format!("n {}", sorted.len())]).collect();
    words.join(", ")
}

/// The share of sorted values above each of them, %, at as many values as can be told apart.
fn longer(sorted: &[f64]) -> Vec<(f64, f64)> {
    let n = sorted.len();
    let first = sorted.partition_point(|ms| *ms <= 0.0);
    let step = ((n - first) / POINTS).max(1);
    let tail = n.saturating_sub(TAIL);
    let places = (first..tail).step_by(step).chain(tail.max(first)..n);
    places
        .filter_map(|at| Some((*sorted.get(at)?, (n - at) as f64 / n as f64 * 100.0)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::longer;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_curve_falls_and_ends_at_the_longest(mut values in prop::collection::vec(0.0f64..99.0, 1..2000)) {
            values.push(100.0);
            values.sort_by(f64::total_cmp);
            let points = longer(&values);
            prop_assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 > pair[1].1));
            prop_assert_eq!(points.last().map(|(ms, _)| *ms), Some(100.0));
        }
    }
}
