//! What a panel of a step response shows beside its curves: its range, the reference with the band about
//! it, and the settling in words.

use chart::{Guide, GuideAt, Series};

use crate::group::{Estimate, Group};
use crate::number::significant;

/// The band about the reference in which a response has settled, as a share of it.
const BAND: f64 = 0.02;
/// The y axis reaches at least to this share of the reference.
const HIGH: f64 = 1.2;

/// A median settling, ms, as text.
#[must_use]
pub fn settled(settling_ms: Estimate) -> String {
    if settling_ms.value.is_infinite() {
        "not settled".to_owned()
    } else {
        format!("{} s", significant(settling_ms.value / 1e3, 3))
    }
}

/// End of the time axis, s: twice the slowest median settling, rounded up to half a second, but no
/// more than the length of the runs.
#[must_use]
pub fn horizon_s<'a, 'b: 'a>(groups: impl Iterator<Item = &'a Group<'b>>) -> f64 {
    let (mut settled_ms, mut length_s) = (0.0f64, 0.0f64);
    for group in groups {
        settled_ms = settled_ms.max(group.settling_ms().map_or(0.0, |ms| ms.value));
        for run in &group.runs {
            length_s = length_s.max(run.cell.duration_ns as f64 / 1e9);
        }
    }
    let wanted_s = (2.0 * settled_ms / 500.0).ceil() / 2.0;
    wanted_s.min(length_s)
}

/// The range of the lines. A band may go further and is cut, since one stall among few runs would
/// flatten everything else.
/// `None` if there is nothing but zero.
#[must_use]
pub fn range(series: &[Series], r: f64) -> Option<(f64, f64)> {
    let ys = series.iter().flat_map(|series| &series.points);
    let finite = ys.map(|(_, y)| *y).filter(|y| y.is_finite());
    let ends = (f64::min(0.0, HIGH * r), f64::max(0.0, HIGH * r));
    let (low, high) = finite.fold(ends, |(low, high), y| (low.min(1.1 * y), high.max(1.1 * y)));
    (low < high).then_some((low, high))
}

/// The reference and the band about it in which a response has settled.
#[must_use]
pub fn guides(r: f64) -> Vec<Guide> {
    [
        ("reference", r),
        ("2 % band", r * (1.0 + BAND)),
        ("2 % band", r * (1.0 - BAND)),
    ]
    .map(|(name, y)| Guide {
        name: name.to_owned(),
        at: GuideAt::Y(y),
    })
    .into()
}
