//! Positions of the columns and rows of a map in its panel.

use crate::axis::Scale;
use crate::chart::Panel;
use crate::map::{Along, Map, Tile};
use crate::span::{Span, drawable};

/// The panel's map, if it has something to show.
pub(crate) fn map(panel: &Panel) -> Option<&Map> {
    let map = panel.map.as_ref()?;
    let shows = map.all().any(|tile| tile != Tile::None);
    let fits = ends(&map.x, panel.x.scale).is_some() && ends(&map.y, panel.y.scale).is_some();
    (shows && fits).then_some(map)
}

/// The two ends of all columns or rows together, in numbers of the axis.
pub(crate) fn ends(along: &Along, scale: Scale) -> Option<(f64, f64)> {
    let lanes = lanes(along, scale);
    Some((lanes.first()?.from, lanes.last()?.to))
}

/// One column or one row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lane {
    /// Its index in the map's list.
    pub(crate) index: usize,
    /// The position that was asked for, in numbers of the axis.
    pub(crate) middle: f64,
    /// Lower and upper end.
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// The columns or rows that are in a panel, with their ends cut to it: 0 is its start, 1 its end.
pub(crate) fn seen(along: &Along, span: &Span) -> Vec<Lane> {
    let place = |end: f64| span.fraction(end).map(|at| at.clamp(0.0, 1.0));
    lanes(along, span.scale)
        .into_iter()
        .filter_map(|lane| {
            let (from, to) = (place(lane.from)?, place(lane.to)?);
            (from < to).then_some(Lane { from, to, ..lane })
        })
        .collect()
}

/// Columns or rows side by side: each ends where the next begins.
fn lanes(along: &Along, scale: Scale) -> Vec<Lane> {
    let middles: Vec<(usize, f64)> = match along {
        Along::Numbers(numbers) => rising(numbers, scale),
        Along::Names(names) => (0..names.len())
            .map(|index| (index, index as f64))
            .collect(),
    };
    let (Some(first), Some(last)) = (middles.first(), middles.last()) else {
        return Vec::new();
    };
    let start = match middles.get(1) {
        Some(second) => beyond(first.1, second.1, scale),
        None => alone(first.1, -1.0, scale),
    };
    // An axis that starts at zero or above does not go below zero only for the width of a tile.
    let start = match along {
        Along::Numbers(_) if first.1 >= 0.0 => start.max(0.0),
        Along::Numbers(_) | Along::Names(_) => start,
    };
    let end = match middles.iter().rev().nth(1) {
        Some(before) => beyond(last.1, before.1, scale),
        None => alone(last.1, 1.0, scale),
    };
    let mut from = start;
    middles
        .iter()
        .enumerate()
        .map(|(at, (index, middle))| {
            let to = match middles.get(at + 1) {
                Some((_, next)) => between(*middle, *next, scale),
                None => end,
            };
            let lane = Lane {
                index: *index,
                middle: *middle,
                from,
                to,
            };
            from = to;
            lane
        })
        .collect()
}

/// The numbers that can be drawn on the axis and are above the one before, with their indices.
fn rising(numbers: &[f64], scale: Scale) -> Vec<(usize, f64)> {
    let mut rising: Vec<(usize, f64)> = Vec::with_capacity(numbers.len());
    for (index, number) in numbers.iter().enumerate() {
        let rises = rising.last().is_none_or(|(_, last)| number > last);
        if drawable(*number, scale) && rises {
            rising.push((index, *number));
        }
    }
    rising
}

/// The middle of two numbers, on the scale of the axis.
fn between(a: f64, b: f64, scale: Scale) -> f64 {
    match scale {
        Scale::Linear => a / 2.0 + b / 2.0,
        Scale::Log => a.sqrt() * b.sqrt(),
    }
}

/// The place beyond `end` at the distance from `end` to the middle between `end` and `inner`.
fn beyond(end: f64, inner: f64, scale: Scale) -> f64 {
    match scale {
        Scale::Linear => (end + (end / 2.0 - inner / 2.0)).clamp(f64::MIN, f64::MAX),
        Scale::Log => (end * (end.sqrt() / inner.sqrt())).clamp(f64::MIN_POSITIVE, f64::MAX),
    }
}

/// The end of a tile that has no neighbour; `side` is -1 or 1.
fn alone(middle: f64, side: f64, scale: Scale) -> f64 {
    match scale {
        Scale::Linear => middle + 0.5 * side,
        Scale::Log => (middle * 10_f64.powf(0.5 * side)).clamp(f64::MIN_POSITIVE, f64::MAX),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn tiles_meet_half_way_and_stop_at_zero() {
        let edges = |numbers: &[f64], scale| -> Vec<f64> {
            let lanes = lanes(&Along::Numbers(numbers.to_vec()), scale);
            let mut edges: Vec<f64> = lanes.iter().map(|lane| lane.from).collect();
            edges.extend(lanes.last().map(|lane| lane.to));
            edges
        };
        assert_eq!(
            edges(&[10.0, 20.0, 60.0], Scale::Linear),
            [5.0, 15.0, 40.0, 80.0]
        );
        assert_eq!(edges(&[0.0, 2.0], Scale::Linear), [0.0, 1.0, 3.0]);
        assert_eq!(edges(&[-1.0, 1.0], Scale::Linear), [-2.0, 0.0, 2.0]);
        assert_eq!(edges(&[1.0, 4.0, 16.0], Scale::Log), [0.5, 2.0, 8.0, 32.0]);
        assert_eq!(edges(&[3.0], Scale::Linear), [2.5, 3.5]);
    }

    #[test]
    fn what_does_not_rise_is_left_out() {
        let numbers = Along::Numbers(vec![0.0, 1.0, 1.0, f64::NAN, 0.5, 2.0]);
        let kept = |scale| -> Vec<usize> {
            let lanes = lanes(&numbers, scale);
            lanes.iter().map(|lane| lane.index).collect()
        };
        assert_eq!(kept(Scale::Linear), [0, 1, 5]);
        assert_eq!(kept(Scale::Log), [1, 5]);
    }

    proptest! {
        #[test]
        fn every_tile_has_its_middle_within(
            mut numbers in proptest::collection::vec(0.001..1e4_f64, 1..40),
            is_log in any::<bool>(),
        ) {
            numbers.sort_by(f64::total_cmp);
            numbers.dedup();
            let scale = if is_log { Scale::Log } else { Scale::Linear };
            let lanes = lanes(&Along::Numbers(numbers.clone()), scale);
            prop_assert_eq!(lanes.len(), numbers.len());
            for lane in &lanes {
                let slack = lane.middle * 1e-12;
                prop_assert!(lane.from - slack <= lane.middle && lane.middle <= lane.to + slack);
            }
        }
    }
}
