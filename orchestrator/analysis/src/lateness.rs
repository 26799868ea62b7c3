//! Lateness of each message against its schedule, `(a_k - a_0) - k h` (Fig. 2, 3 and 4): the series,
//! its slope, and the residuals about its line.
//!
//! k is the message's `seq`. On an absolute schedule `seq` is the number of the deadline, and missed
//! deadlines count. A client that skips deadlines is therefore not late; `sent_share` says how many
//! of the due messages it sent. A relative schedule has no deadlines to miss: `seq` counts the
//! messages, and k h is when the k-th should have arrived. This is the paper's definition. Both
//! schedules start with the first message that arrived.

use std::path::Path;

use endpoint::ArrivalRow;
use plan::file_name;
use record::ReadError;
use record::rows::read;
use serde::{Deserialize, Serialize};

use crate::statistics::{Line, Quantiles, lower_median, share};

/// One arrival against its schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Late {
    /// The message's `seq`.
    pub seq: u64,
    /// When it was due, k h, s.
    pub due_s: f64,
    /// Lateness in ms, if the first arrival was on time; negative is early.
    pub late_ms: f64,
}

/// Compares arrivals with the schedule that starts at the first of them.
#[derive(Debug)]
struct Schedule {
    h_ns: u64,
    first: Option<ArrivalRow>,
}

impl Schedule {
    fn late(&mut self, row: &ArrivalRow) -> Late {
        let first = *self.first.get_or_insert(*row);
        let due_ns = |row: &ArrivalRow| row.seq.saturating_mul(self.h_ns);
        // In integers, so that a nanosecond is not lost after ten minutes at 1 kHz.
        let off_ns = |row: &ArrivalRow| i128::from(row.t_arrive_ns) - i128::from(due_ns(row));
        Late {
            seq: row.seq,
            due_s: due_ns(row) as f64 / 1e9,
            late_ms: (off_ns(row) - off_ns(&first)) as f64 / 1e6,
        }
    }
}

/// Passes each arrival of a cell's folder to `each`, in order of arrival. Returns whether the last
/// line was torn.
///
/// # Errors
/// [`ReadError`] if `arrivals.csv` cannot be read.
pub fn series(folder: &Path, h_ns: u64, mut each: impl FnMut(Late)) -> Result<bool, ReadError> {
    let mut schedule = Schedule { h_ns, first: None };
    let path = folder.join(file_name::ARRIVALS);
    read(&path, |row| each(schedule.late(row)))
}

/// Summary of a series of lateness.
///
/// Residuals are about the line that has the least-squares slope and as many arrivals above it as
/// below. A few stalls would pull a line through the mean away from the regular arrivals.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Drift {
    /// Least-squares slope of lateness over k h, s/s; 0 if the schedule is kept.
    pub slope: Option<f64>,
    /// The lateness of the last arrival, s.
    pub lag_s: Option<f64>,
    /// Median magnitude of the residuals, ms.
    pub residual_p50_ms: Option<f64>,
    /// Greatest magnitude of the residuals, ms.
    pub residual_max_ms: Option<f64>,
    /// Share of arrivals off the line: by more than [`IMPULSE`] median residuals and by more than
    /// [`IMPULSE_MS`].
    pub impulse_share: Option<f64>,
    /// The longest sequence of such arrivals: short if the error is an impulse and returns to the line.
    pub impulse_longest: Option<u64>,
}

/// A residual of more than this many medians is off the line. With normal noise, fewer than one in a
/// thousand are.
pub const IMPULSE: f64 = 5.0;
/// A residual of at most this, ms, is never off the line: a machine's scheduling delays any client by
/// as much.
pub const IMPULSE_MS: f64 = 1.0;

/// Accumulates [`Drift`] row by row.
#[derive(Debug)]
pub(crate) struct DriftCount {
    schedule: Schedule,
    line: Line,
    due_s: Vec<f64>,
    late_ms: Vec<f64>,
}

impl DriftCount {
    pub(crate) fn new(h_ns: u64) -> Self {
        Self {
            schedule: Schedule { h_ns, first: None },
            line: Line::default(),
            due_s: Vec::new(),
            late_ms: Vec::new(),
        }
    }

    pub(crate) fn push(&mut self, row: &ArrivalRow) {
        let late = self.schedule.late(row);
        self.line.push(late.due_s, late.late_ms / 1e3);
        self.due_s.push(late.due_s);
        self.late_ms.push(late.late_ms);
    }

    pub(crate) fn finish(self) -> Drift {
        let slope = self.line.slope();
        let drift = Drift {
            slope,
            lag_s: self.late_ms.last().map(|late_ms| late_ms / 1e3),
            ..Drift::default()
        };
        slope.map_or(drift, |slope| drift.about(slope, self.due_s, self.late_ms))
    }
}

impl Drift {
    /// Adds the residuals about the line of this slope. Overwrites both series, to save memory: ten
    /// minutes at 1 kHz are not kept a third and a fourth time.
    fn about(self, slope: f64, due_s: Vec<f64>, late_ms: Vec<f64>) -> Self {
        let mut residuals_ms = late_ms;
        for (residual, due_s) in residuals_ms.iter_mut().zip(&due_s) {
            *residual -= slope * due_s * 1e3;
        }
        let mut any_order = due_s;
        any_order.copy_from_slice(&residuals_ms);
        let middle_ms = lower_median(&mut any_order, f64::total_cmp).unwrap_or(0.0);
        let off_ms = |residual_ms: f64| (residual_ms - middle_ms).abs();
        let off_ns = any_order.into_iter().map(|ms| (off_ms(ms) * 1e6) as u64);
        let off = Quantiles::of(off_ns.collect());
        let Some(p50_ms) = off.p50_ms else {
            return self;
        };
        let limit_ms = (IMPULSE * p50_ms).max(IMPULSE_MS);
        let (mut impulses, mut longest, mut in_a_row) = (0, 0, 0);
        for residual_ms in &residuals_ms {
            in_a_row = if off_ms(*residual_ms) > limit_ms {
                impulses += 1;
                in_a_row + 1
            } else {
                0
            };
            longest = longest.max(in_a_row);
        }
        Self {
            residual_p50_ms: Some(p50_ms),
            residual_max_ms: off.max_ms,
            impulse_share: share(impulses, residuals_ms.len() as u64),
            impulse_longest: Some(longest),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrival::tests::rows;
    use proptest::prelude::*;

    fn drift(h_ns: u64, arrivals: impl IntoIterator<Item = (u64, u64)>) -> Drift {
        let mut count = DriftCount::new(h_ns);
        for row in rows(h_ns, arrivals) {
            count.push(&row);
        }
        count.finish()
    }

    const H_NS: u64 = 10_000_000;

    #[test]
    fn a_client_that_takes_ten_point_nine_ms_for_ten_drifts_as_the_paper_s_javascript() {
        // (10.9 - 10)/10 = 0.09 s/s; after 55 000 messages, 599.5 s, it is 49.5 s late.
        let late = drift(
            H_NS,
            (0..55_001).map(|k| (k, 7_000_000_000 + k * 10_900_000)),
        );
        assert!((late.slope.expect("many") - 0.09).abs() < 1e-9);
        assert!((late.lag_s.expect("many") - 49.5).abs() < 1e-6);
        assert!(late.residual_max_ms.expect("many") < 1e-3);
    }

    #[test]
    fn a_client_that_leaves_every_other_deadline_out_is_on_time_with_the_rest() {
        let half = drift(H_NS, (0..100).map(|n| (2 * n, 2 * n * H_NS)));
        assert_eq!((half.slope, half.lag_s), (Some(0.0), Some(0.0)));
        // The same messages, counted by a relative schedule: each takes 2 h.
        let slow = drift(H_NS, (0..100).map(|n| (n, 2 * n * H_NS)));
        assert!((slow.slope.expect("many") - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_stall_is_an_impulse_and_a_step_is_not() {
        // 1000 messages with 0.1 ms of noise; every hundredth is 50 ms late, each on its own.
        let noise = |k: u64| k * H_NS + (k * 7919 % 11) * 10_000;
        let alone = |k: u64| noise(k) + if k % 100 == 50 { 50_000_000 } else { 0 };
        let impulses = drift(H_NS, (0..1000).map(|k| (k, alone(k))));
        assert_eq!(
            (impulses.impulse_share, impulses.impulse_longest),
            (Some(0.01), Some(1))
        );
        assert!((impulses.residual_max_ms.expect("many") - 50.0).abs() < 0.5);
        assert!(impulses.residual_p50_ms.expect("many") < 0.1);

        // From the middle on every message is 50 ms late: the line lies between, and nothing returns
        // to it.
        let step = |k: u64| noise(k) + if k >= 500 { 50_000_000 } else { 0 };
        let step = drift(H_NS, (0..1000).map(|k| (k, step(k))));
        assert!(step.residual_p50_ms.expect("many") > 5.0, "{step:?}");
    }

    #[test]
    fn noise_below_a_millisecond_is_no_impulse_however_quiet_the_rest_is() {
        let quiet = |k: u64| k * H_NS + if k.is_multiple_of(10) { 900_000 } else { 0 };
        let drift = drift(H_NS, (0..1000).map(|k| (k, quiet(k))));
        assert_eq!(
            (drift.impulse_share, drift.impulse_longest),
            (Some(0.0), Some(0))
        );
    }

    #[test]
    fn of_nothing_and_of_one_arrival_nothing_is_said_and_no_number_is_too_large() {
        assert_eq!(drift(H_NS, []), Drift::default());
        let one = drift(H_NS, [(3, 5)]);
        assert_eq!((one.slope, one.lag_s), (None, Some(0.0)));
        let wild = drift(H_NS, [(u64::MAX, 0), (0, u64::MAX)]);
        assert!(wild.slope.is_some());
    }

    proptest! {
        #[test]
        fn the_slope_is_what_a_constant_delay_and_another_start_leave_alone(
            extra_ns in 0u64..1_000_000, start_ns in 0u64..1 << 40, first in 0u64..50, n in 20u64..200,
        ) {
            let at = |k: u64| start_ns + k * (H_NS + extra_ns);
            let drift = drift(H_NS, (first..first + n).map(|k| (k, at(k))));
            let slope = extra_ns as f64 / H_NS as f64;
            prop_assert!((drift.slope.expect("many") - slope).abs() < 1e-9);
            prop_assert!((drift.lag_s.expect("many") - (n - 1) as f64 * extra_ns as f64 / 1e9).abs() < 1e-9);
            prop_assert_eq!(drift.impulse_longest, Some(0));
        }
    }
}
