//! From where to where an axis goes, and where on it a number is.
//!
//! Halves are taken before differences, so that no two finite numbers are too far apart.

use crate::chart::{Axis, GuideAt, Mark, Panel, Scale};
use crate::grid;
use crate::map::Along;

/// Beyond this many axis lengths from an axis, places are not told apart.
const FAR: f64 = 1e4;

/// From where to where an axis goes; `lo` below `hi`, both finite, above zero if by powers of ten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
    pub(crate) scale: Scale,
}

impl Span {
    /// Both axes of a panel; none where there is nothing to draw.
    pub(crate) fn of(panel: &Panel) -> Option<(Span, Span)> {
        if let Some(map) = grid::map(panel) {
            return Some((
                Span::across(&panel.x, &map.x)?,
                Span::across(&panel.y, &map.y)?,
            ));
        }
        let x_values = panel.series.iter().flat_map(|series| {
            let half = match series.mark {
                Mark::Bars(width) => width / 2.0,
                Mark::Line | Mark::Steps | Mark::Dots => 0.0,
            };
            series
                .points
                .iter()
                .filter(|point| drawable(point.1, panel.y.scale))
                .flat_map(move |point| [point.0 - half, point.0 + half])
        });
        let x_guides = panel.guides.iter().filter_map(|guide| match guide.at {
            GuideAt::X(x) => Some(x),
            GuideAt::Y(_) | GuideAt::Line(..) => None,
        });
        let x = Span::along(&panel.x, x_values, x_guides, 0.02)?;

        let seen = |value: f64| {
            x.fraction(value)
                .is_some_and(|at| (0.0..=1.0).contains(&at))
        };
        let y_values = panel.series.iter().flat_map(|series| {
            let bands = series.band.len() == series.points.len();
            let floor = match series.mark {
                Mark::Bars(_) => Some(0.0),
                Mark::Line | Mark::Steps | Mark::Dots => None,
            };
            series
                .points
                .iter()
                .enumerate()
                .filter(move |(_, point)| seen(point.0))
                .flat_map(move |(index, point)| {
                    let band = bands.then(|| series.band.get(index)).flatten();
                    [Some(point.1), band.map(|b| b.0), band.map(|b| b.1), floor]
                })
                .flatten()
        });
        let y_guides = panel.guides.iter().filter_map(|guide| match guide.at {
            GuideAt::Y(y) => Some(y),
            GuideAt::X(_) | GuideAt::Line(..) => None,
        });
        let y = Span::along(&panel.y, y_values, y_guides, 0.05)?;
        Some((x, y))
    }

    /// The range that was asked for if it can be drawn, else that of the data and, with them, of
    /// the guides. None without data, and none where all data are outside the asked range.
    fn along(
        axis: &Axis,
        values: impl Iterator<Item = f64>,
        guides: impl Iterator<Item = f64>,
        margin: f64,
    ) -> Option<Span> {
        let scale = axis.scale;
        let least_most = |(lo, hi): (f64, f64), v: f64| (lo.min(v), hi.max(v));
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let data = values
            .filter(|v| drawable(*v, scale))
            .fold(none, least_most);
        if data.0 > data.1 {
            return None;
        }
        if let Some(asked) = Span::asked(axis) {
            return Some(asked);
        }
        let (lo, hi) = guides
            .filter(|v| drawable(*v, scale))
            .fold(data, least_most);
        Some(Span { lo, hi, scale }.widened().with_margin(margin))
    }

    /// The range that was asked for, if it can be drawn.
    pub(crate) fn asked(axis: &Axis) -> Option<Span> {
        let (scale, (lo, hi)) = (axis.scale, axis.range?);
        let is_range = lo < hi && drawable(lo, scale) && drawable(hi, scale);
        is_range.then(|| Span { lo, hi, scale }.widened())
    }

    /// From the first end of a map's columns or rows to the last, or as asked for; none where there
    /// are none.
    fn across(axis: &Axis, along: &Along) -> Option<Span> {
        let (asked, scale) = match along {
            Along::Numbers(_) => (Span::asked(axis), axis.scale),
            Along::Names(_) => (None, Scale::Linear),
        };
        let (lo, hi) = grid::ends(along, scale)?;
        asked.or_else(|| Some(Span { lo, hi, scale }.widened()))
    }

    /// Wide enough to have places in it.
    pub(crate) fn widened(self) -> Span {
        let Span { lo, hi, scale } = self;
        let size = lo.abs().max(hi.abs());
        if hi / 2.0 - lo / 2.0 > (size * 1e-13).max(f64::MIN_POSITIVE * 1e6) {
            return self;
        }
        match scale {
            Scale::Log => Span {
                lo: (lo / 2.0).max(f64::MIN_POSITIVE),
                hi: (hi.max(f64::MIN_POSITIVE) * 2.0).min(f64::MAX),
                scale,
            },
            Scale::Linear => {
                let by = if size < f64::MIN_POSITIVE * 1e12 {
                    1.0
                } else {
                    size * 0.05
                };
                Span {
                    lo: (lo - by).max(f64::MIN),
                    hi: (hi + by).min(f64::MAX),
                    scale,
                }
            }
        }
    }

    /// A little wider than the data, but not across zero.
    fn with_margin(self, margin: f64) -> Span {
        let Span { lo, hi, scale } = self;
        match scale {
            Scale::Log => {
                let by = (hi.log10() - lo.log10()) * margin;
                Span {
                    lo: 10_f64.powf(lo.log10() - by).max(f64::MIN_POSITIVE),
                    hi: 10_f64.powf(hi.log10() + by).min(f64::MAX),
                    scale,
                }
            }
            Scale::Linear => {
                let by = (hi / 2.0 - lo / 2.0) * margin * 2.0;
                let below = (lo - by).max(f64::MIN);
                let above = (hi + by).min(f64::MAX);
                Span {
                    lo: if lo >= 0.0 { below.max(0.0) } else { below },
                    hi: if hi <= 0.0 { above.min(0.0) } else { above },
                    scale,
                }
            }
        }
    }

    /// Where on the axis a number is: 0 at its start, 1 at its end. None if it cannot be drawn.
    pub(crate) fn fraction(&self, value: f64) -> Option<f64> {
        if !drawable(value, self.scale) {
            return None;
        }
        let (value, lo, hi) = match self.scale {
            Scale::Linear => (value / 2.0, self.lo / 2.0, self.hi / 2.0),
            Scale::Log => (value.log10(), self.lo.log10(), self.hi.log10()),
        };
        let at = (value - lo) / (hi - lo);
        Some(at.clamp(-FAR, FAR))
    }

    /// The number that bars stand on.
    pub(crate) fn floor(&self) -> f64 {
        match self.scale {
            Scale::Linear => 0.0,
            Scale::Log => self.lo,
        }
    }
}

/// Whether a number can be on an axis of this scale.
pub(crate) fn drawable(value: f64, scale: Scale) -> bool {
    value.is_finite() && (scale == Scale::Linear || value > 0.0)
}
