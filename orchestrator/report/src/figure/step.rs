//! What a panel of a step response shows beside its curves: its range, the reference with the band about
//! it, and the settling in words.

use chart::{Guide, GuideAt, Series};
use text::significant;

use crate::called::is_kept;
use crate::group::{Estimate, Group};

/// The band about the reference in which a step has settled if its system asks for none, as a share of it.
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
/// more than the length of the runs; all of it where a loop is to stay where it is.
#[must_use]
pub fn horizon_s<'a, 'b: 'a>(groups: impl Iterator<Item = &'a Group<'b>>) -> f64 {
    let (mut settled_ms, mut length_s) = (0.0f64, 0.0f64);
    for group in groups {
        let settled = group.settling_ms().map_or(0.0, |ms| ms.value);
        // What is to stay in its band is to do so until the end.
        let stays = group.runs.iter().any(|run| is_kept(run));
        settled_ms = settled_ms.max(if stays { f64::INFINITY } else { settled });
        for run in &group.runs {
            length_s = length_s.max(run.cell.duration_ns as f64 / 1e9);
        }
    }
    let wanted_s = (2.0 * settled_ms / 500.0).ceil() / 2.0;
    wanted_s.min(length_s)
}

/// The range of the lines, the reference and the `band` about it, half its width. The quartiles may go further and
/// are cut, since one stall among few runs would flatten everything else. `None` if there is nothing but zero.
#[must_use]
pub fn range(series: &[Series], r: f64, band: Option<f64>) -> Option<(f64, f64)> {
    let ys = series.iter().flat_map(|series| &series.points);
    let finite = ys.map(|(_, y)| *y).filter(|y| y.is_finite());
    let band = HIGH * band.unwrap_or_default();
    let ends = (
        f64::min(0.0, HIGH * r).min(r - band),
        f64::max(0.0, HIGH * r).max(r + band),
    );
    let (low, high) = finite.fold(ends, |(low, high), y| (low.min(1.1 * y), high.max(1.1 * y)));
    (low < high).then_some((low, high))
}

/// Half the width of the band in which loops without a system of their own settle.
#[must_use]
pub fn usual_band(r: f64) -> f64 {
    BAND * r.abs()
}

/// The reference and the band about it in which the rule judged the loop: half its width, in units of y; `None` if
/// nothing gives its scale.
#[must_use]
pub fn guides(r: f64, band: Option<f64>) -> Vec<Guide> {
    let guide = |(name, y): (&str, f64)| Guide {
        name: name.to_owned(),
        at: GuideAt::Y(y),
    };
    let name = match band {
        Some(band) if (band - usual_band(r)).abs() <= 1e-9 * band => "2 % band",
        _ => "band",
    };
    let ends = band.map_or(Vec::new(), |band| vec![(name, r + band), (name, r - band)]);
    [("reference", r)]
        .into_iter()
        .chain(ends)
        .map(guide)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_the_one_that_the_loop_was_judged_by() {
        let drawn = |r, band| -> Vec<(String, GuideAt)> {
            let guides = guides(r, band).into_iter();
            guides.map(|guide| (guide.name, guide.at)).collect()
        };
        let at = |name: &str, y| (name.to_owned(), GuideAt::Y(y));
        assert_eq!(
            drawn(1.0, Some(0.02)),
            [
                at("reference", 1.0),
                at("2 % band", 1.02),
                at("2 % band", 0.98)
            ]
        );
        // A pendulum at r = 0 has the band that its system asks for, and the axis shows all of it.
        assert_eq!(
            drawn(0.0, Some(0.01)),
            [at("reference", 0.0), at("band", 0.01), at("band", -0.01)]
        );
        assert_eq!(drawn(0.0, None), [at("reference", 0.0)]);
        let (low, high) = range(&[], 0.0, Some(0.01)).expect("a band");
        assert!(low < -0.01 && high > 0.01, "{low} {high}");
    }
}
