//! The range of an axis, and the positions of numbers on it.
//!
//! Numbers are halved before they are subtracted, so that the difference of two finite numbers does
//! not overflow.

use crate::axis::{Axis, Scale};

/// A position is at most this many axis lengths from the start of an axis; beyond that it is clamped.
const FAR: f64 = 1e4;

/// The range of an axis: `lo` is below `hi`, both are finite, and above zero if the scale is
/// logarithmic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
    pub(crate) scale: Scale,
}

impl Span {
    /// The range that was asked for, if it can be drawn.
    pub(crate) fn asked(axis: &Axis) -> Option<Span> {
        let (scale, (lo, hi)) = (axis.scale, axis.range?);
        let is_range = lo < hi && drawable(lo, scale) && drawable(hi, scale);
        is_range.then(|| Span { lo, hi, scale }.widened())
    }

    /// Widens the range if it is too narrow to tell positions apart.
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

    /// Widens the range by a part of its length, but not across zero.
    pub(crate) fn with_margin(self, margin: f64) -> Span {
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

    /// The position of a number on the axis: 0 at its start, 1 at its end. `None` if it cannot be
    /// drawn.
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

/// Whether a number can be drawn on an axis of this scale.
pub(crate) fn drawable(value: f64, scale: Scale) -> bool {
    value.is_finite() && (scale == Scale::Linear || value > 0.0)
}
