//! How much of a panel is shown: all of a loop that holds, and of one that does not only what flattens no other.

use analysis::{Reason, Run};
use chart::Series;

/// The lowest and the highest of the loops that hold, with their bands; `None` if none holds.
pub(super) fn held_ends(series: &[Series], held: &[bool]) -> Option<(f64, f64)> {
    let shown = series.iter().zip(held).filter(|(_, held)| **held);
    ends(shown.map(|(series, _)| series))
}

fn ends<'a>(series: impl Iterator<Item = &'a Series>) -> Option<(f64, f64)> {
    let values = series.flat_map(|series| {
        let bands = series.band.iter().flat_map(|(low, high)| [*low, *high]);
        series.points.iter().map(|(_, y)| *y).chain(bands)
    });
    let (low, high) = values
        .filter(|y| y.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
    (low <= high).then_some((low, high))
}

/// A range that shows the inputs of the loops that hold, with as much again above and below; `None` if that
/// cuts nothing, or none holds.
pub(super) fn held_range(series: &[Series], held: &[bool]) -> Option<(f64, f64)> {
    let ((low, high), whole) = (held_ends(series, held)?, ends(series.iter())?);
    let (low, high) = (2.0 * low - high, 2.0 * high - low);
    (low < high && (whole.0 < low || whole.1 > high)).then_some((low, high))
}

/// How far from r a run's output was when it left its limits; `None` if it did not.
pub(super) fn left_at(run: &Run, r: f64) -> Option<f64> {
    match run.metrics.as_ref()?.response?.reason? {
        Reason::Limits { y, .. } => Some((y - r).abs()),
        _ => None,
    }
}

/// A range that shows an input until an instant, with as much again above and below; `None` if it stood still.
pub(super) fn until(series: &[Series], end_s: f64) -> Option<(f64, f64)> {
    let points = series.iter().flat_map(|series| &series.points);
    let values = points.filter(|(at_s, _)| *at_s <= end_s).map(|(_, u)| *u);
    let (low, high) = values
        .filter(|u| u.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| {
            (low.min(u), high.max(u))
        });
    (low < high).then_some((2.0 * low - high, 2.0 * high - low))
}

/// The part of a range about r that shows an output leave its limits, with as much again: `farthest` is how far from
/// r it was then. All of it where there are none.
pub(super) fn about((low, high): (f64, f64), r: f64, farthest: Option<f64>) -> (f64, f64) {
    match farthest {
        Some(farthest) => (low.max(r - 2.0 * farthest), high.min(r + 2.0 * farthest)),
        None => (low, high),
    }
}

/// The part of a range that shows the loops that hold: a loop that does not leaves the panel, and would
/// flatten the others.
pub(super) fn within(
    (low, high): (f64, f64),
    r: impl IntoIterator<Item = f64>,
    held: Option<(f64, f64)>,
) -> (f64, f64) {
    /// Farthest from r, in units of its largest step from rest; about 0, of what the loops that hold take up.
    const FARTHEST: f64 = 2.0;
    let widen = |(least, most): (f64, f64), r: f64| (r.min(least), r.max(most));
    let (least, most) = r.into_iter().fold((0.0, 0.0), widen);
    // About 0 there is no step: what holds gives the scale.
    let step = match most - least {
        0.0 => held.map_or(0.0, |(low, high)| high - low),
        step => step,
    };
    let span = FARTHEST * step;
    if span == 0.0 {
        return (low, high);
    }
    // Room above a curve that holds, so that its peak is seen to be one.
    let held = held.map_or((0.0, 0.0), |(low, high)| {
        let room = 0.05 * (high - low);
        (low - room, high + room)
    });
    (
        low.max(least - span).min(held.0),
        high.min(most + span).max(held.1),
    )
}

#[cfg(test)]
mod tests {
    use chart::Mark;

    use super::super::step::range;
    use super::*;
    use crate::tone::OTHER_TONE;

    #[test]
    fn a_loop_that_holds_is_never_cut_and_one_that_does_not_flattens_no_other() {
        let series = |peak: f64| {
            Series::new(
                String::new(),
                Mark::Line,
                OTHER_TONE,
                vec![(0.0, 0.0), (0.1, peak), (0.2, 1.0)],
            )
        };
        let all = [series(14.3), series(1e9)];
        let seen = range(&all, 1.0, None).expect("drawn");
        let (_, both_lost) = within(seen, [1.0], held_ends(&all, &[false, false]));
        assert!((both_lost - 3.0).abs() < 1e-9, "{both_lost}");
        let (low, high) = within(seen, [1.0], held_ends(&all, &[true, false]));
        assert!(low <= 0.0 && (14.3..20.0).contains(&high), "{low} {high}");
        // About r = 0 a fallen pendulum flattens no balanced one, and alone it is seen whole.
        let fallen = (-0.02, 4.1);
        let (low, high) = within(fallen, [0.0], Some((-0.02, 0.05)));
        assert!(low <= -0.02 && (0.05..0.3).contains(&high), "{low} {high}");
        assert_eq!(within(fallen, [0.0], None), fallen);
        // Alone it is seen to leave its limits, where it has some.
        assert_eq!(about(fallen, 0.0, None), fallen);
        assert_eq!(about(fallen, 0.0, Some(0.5)), (-0.02, 1.0));
        // Its band is a part of it.
        let banded = Series {
            band: vec![(0.0, 0.0), (-2.0, 25.0), (1.0, 1.0)],
            ..series(14.3)
        };
        let (low, high) = within((0.0, 16.0), [1.0], held_ends(&[banded], &[true]));
        assert!(low <= -2.0 && high >= 25.0, "{low} {high}");
    }
}
