//! The slope of lateness over the schedule, with an interval that stalls do not make too narrow.

use analysis::Run;
use analysis::lateness::{self, IMPULSE, IMPULSE_MS};
use analysis::statistics::{Line, mean, upper_median};

use record::ReadError;
use report::group::Estimate;

/// Number of blocks into which a series is cut; lateness in one says little about the next.
const BLOCKS: usize = 12;
/// Student's t with `BLOCKS - 1` degrees of freedom: 95 % lie within.
const STUDENT_95: f64 = 2.201;
/// The fewest points for which a slope and its interval are computed.
const POINTS_MIN: usize = 5 * BLOCKS;

/// The lateness of each message of a run.
#[derive(Debug)]
pub(super) struct Series {
    /// Time due and lateness, both in s, in order of arrival.
    points: Vec<(f64, f64)>,
}

impl Series {
    pub(super) fn read(run: &Run) -> Result<Series, ReadError> {
        let mut points = Vec::new();
        lateness::series(&run.folder, run.cell.settings.h.ns(), |late| {
            points.push((late.due_s, late.late_ms / 1e3));
        })?;
        Ok(Series { points })
    }

    /// The same as it is told where each side has a clock of its own and neither is set by the other: time since the
    /// first message, the plant's by a clock that is fast by `apart`.
    pub(super) fn by_another_clock(self, apart: f64) -> Series {
        let first = self.points.first().copied().unwrap_or_default();
        let tell = |(due_s, late_s): (f64, f64)| {
            let (due_s, came_s) = (due_s - first.0, due_s + late_s - first.0 - first.1);
            (due_s, came_s * (1.0 + apart) - due_s)
        };
        Series {
            points: self.points.into_iter().map(tell).collect(),
        }
    }

    /// The least-squares slope, s/s, with its 95 % interval.
    ///
    /// A stall that delays forty messages is one event and not forty, so the usual standard error is
    /// several times too small. Therefore the series is cut into twelve blocks, which are longer than
    /// a stall and taken as independent, and the slope is computed without each block in turn (the
    /// delete-a-group jackknife).
    ///
    /// `None` with fewer than sixty messages, or if all were due at once.
    pub(super) fn least_squares(&self) -> Option<Estimate> {
        let n = self.points.len();
        if n < POINTS_MIN {
            return None;
        }
        let size = n.div_ceil(BLOCKS);
        let slope = |points: &mut dyn Iterator<Item = &(f64, f64)>| {
            let mut line = Line::default();
            points.for_each(|(due_s, late_s)| line.push(*due_s, *late_s));
            line.slope()
        };
        let value = slope(&mut self.points.iter())?;
        let without = |block: usize| {
            let at = |(k, _): &(usize, &(f64, f64))| k / size != block;
            let kept = self.points.iter().enumerate().filter(at);
            slope(&mut kept.map(|(_, point)| point))
        };
        let blocks = n.div_ceil(size);
        let slopes = (0..blocks).map(without).collect::<Option<Vec<f64>>>()?;
        let count = blocks as f64;
        let mean = mean(&slopes);
        let squares: f64 = slopes.iter().map(|slope| (slope - mean).powi(2)).sum();
        let error = (squares * (count - 1.0) / count).sqrt();
        Some(Estimate::around(value, STUDENT_95 * error, n as u64))
    }

    /// Tukey's resistant slope, s/s: from the median point of the first third to that of the last. It
    /// follows the regular messages, however far off a few stalls are. `None` with fewer than sixty
    /// messages, or if all were due at once.
    pub(super) fn resistant(&self) -> Option<f64> {
        let n = self.points.len();
        if n < POINTS_MIN {
            return None;
        }
        let (first, last) = (self.points.get(..n / 3)?, self.points.get(n - n / 3..)?);
        let due_s = middle(last, |point| point.0)? - middle(first, |point| point.0)?;
        let late_s = middle(last, |point| point.1)? - middle(first, |point| point.1)?;
        (due_s > 0.0).then(|| late_s / due_s)
    }

    /// The residuals about the resistant line, which has as many messages above it as below.
    pub(super) fn residuals(&self) -> Option<Residuals> {
        let slope = self.resistant()?;
        let about = |(due_s, late_s): &(f64, f64)| (*due_s, (late_s - slope * due_s) * 1e3);
        let mut points: Vec<(f64, f64)> = self.points.iter().map(about).collect();
        let line_ms = middle(&points, |point| point.1)?;
        for (_, off_ms) in &mut points {
            *off_ms = (*off_ms - line_ms).abs();
        }
        let p50_ms = middle(&points, |point| point.1)?;
        let limit_ms = (IMPULSE * p50_ms).max(IMPULSE_MS);
        let (mut off, mut longest, mut in_a_row) = (0, 0, 0);
        for (_, off_ms) in &points {
            in_a_row = if *off_ms > limit_ms { in_a_row + 1 } else { 0 };
            off += u64::from(in_a_row > 0);
            longest = longest.max(in_a_row);
        }
        Some(Residuals {
            n: points.len() as u64,
            p50_ms,
            off,
            longest,
        })
    }
}

/// Distances of a series from its resistant line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residuals {
    /// Number of messages.
    pub(super) n: u64,
    /// Their median distance, ms.
    pub(super) p50_ms: f64,
    /// Number of messages off the line: by more than [`IMPULSE`] medians and [`IMPULSE_MS`].
    pub(super) off: u64,
    /// The longest sequence of such messages.
    pub(super) longest: u64,
}

fn middle(points: &[(f64, f64)], of: fn(&(f64, f64)) -> f64) -> Option<f64> {
    let mut values: Vec<f64> = points.iter().map(of).collect();
    upper_median(&mut values, f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 600 messages, one every 0.2 s.
    fn series(late_s: impl Fn(usize) -> f64) -> Series {
        let points = (0..600).map(|k| (k as f64 * 0.2, late_s(k))).collect();
        Series { points }
    }

    #[test]
    fn stalls_tilt_the_line_and_the_interval_says_so() {
        // Two stalls of 2 s near the end of a flat series; after each, ten messages arrive together.
        let stalls = series(|k| match k {
            500..510 => (510 - k) as f64 * 0.2,
            560..570 => (570 - k) as f64 * 0.2,
            _ => 0.0,
        });
        let slope = stalls.least_squares().expect("many");
        assert!(slope.value > 3e-4, "{slope:?}");
        assert!(slope.low < 0.0, "{slope:?}");
        assert_eq!(stalls.resistant(), Some(0.0));
        let about = stalls.residuals().expect("many");
        assert_eq!((about.p50_ms, about.off, about.longest), (0.0, 20, 10));
    }

    #[test]
    fn of_few_messages_nothing_is_said() {
        let few = Series {
            points: vec![(0.0, 0.0); POINTS_MIN - 1],
        };
        assert_eq!((few.least_squares(), few.resistant()), (None, None));
        let at_once = Series {
            points: vec![(1.0, 0.0); POINTS_MIN],
        };
        assert_eq!((at_once.least_squares(), at_once.resistant()), (None, None));
    }

    proptest! {
        #[test]
        fn another_clock_tilts_a_line_by_what_it_is_off(
            slope in -0.5f64..2.0, offset in -5.0f64..5.0, apart in -1e-3f64..1e-3,
        ) {
            let told = series(|k| offset + slope * k as f64 * 0.2).by_another_clock(apart);
            let ours = told.least_squares().expect("many").value;
            prop_assert!((ours - (slope + apart * (1.0 + slope))).abs() < 1e-9);
        }

        #[test]
        fn both_slopes_of_an_exact_line_are_its_own(slope in -0.5f64..2.0, offset in -5.0f64..5.0) {
            let exact = series(|k| offset + slope * k as f64 * 0.2);
            let least = exact.least_squares().expect("many");
            prop_assert!((least.value - slope).abs() < 1e-9 && least.high - least.low < 1e-9);
            prop_assert!((exact.resistant().expect("many") - slope).abs() < 1e-9);
        }
    }
}
