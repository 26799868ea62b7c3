//! How well the plant kept its own time (`ticks.csv`).

use endpoint::TickRow;
use serde::{Deserialize, Serialize};

use crate::statistics::{Moments, Quantiles, ms_between, share};

/// A tick at most this far from its deadline, ns, is punctual.
const PUNCTUAL_NS: u64 = 100_000;

/// The plant's ticks: intervals between them, and lateness against their deadlines.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ticks {
    /// Number of ticks.
    pub count: u64,
    /// Mean interval, ms.
    pub interval_avg_ms: Option<f64>,
    /// Standard deviation of the intervals, ms.
    pub interval_sd_ms: Option<f64>,
    /// Share of intervals that are zero or negative: the clock stood still or went back between two
    /// ticks (Fig. 7, compare Table 3).
    pub interval_nonpositive: Option<f64>,
    /// Share of ticks within 0.1 ms of their deadline.
    pub punctual: Option<f64>,
    /// Lateness that 99 % of the ticks do not exceed, ms.
    pub late_p99_ms: Option<f64>,
    /// The greatest lateness, ms.
    pub late_max_ms: Option<f64>,
    /// Ticks late by h or more: the interval of the tick had passed.
    pub missed: u64,
}

/// Accumulates [`Ticks`] row by row.
#[derive(Debug)]
pub(crate) struct TickCount {
    h_ns: u64,
    last_ns: Option<u64>,
    intervals: Moments,
    nonpositive: u64,
    punctual: u64,
    missed: u64,
    late_ns: Vec<u64>,
}

impl TickCount {
    pub(crate) fn new(h_ns: u64) -> Self {
        Self {
            h_ns,
            last_ns: None,
            intervals: Moments::default(),
            nonpositive: 0,
            punctual: 0,
            missed: 0,
            late_ns: Vec::new(),
        }
    }

    pub(crate) fn push(&mut self, row: &TickRow) {
        if let Some(last_ns) = self.last_ns.replace(row.t_tick_ns) {
            self.intervals.push(ms_between(last_ns, row.t_tick_ns));
            self.nonpositive += u64::from(row.t_tick_ns <= last_ns);
        }
        let off_ns = row.t_tick_ns.abs_diff(row.t_due_ns);
        self.punctual += u64::from(off_ns <= PUNCTUAL_NS);
        let late_ns = row.t_tick_ns.saturating_sub(row.t_due_ns);
        self.missed += u64::from(late_ns >= self.h_ns);
        self.late_ns.push(late_ns);
    }

    pub(crate) fn finish(self) -> Ticks {
        let count = self.late_ns.len() as u64;
        let intervals = self.intervals.spread();
        let late = Quantiles::of(self.late_ns);
        Ticks {
            count,
            interval_avg_ms: intervals.map(|spread| spread.avg_ms),
            interval_sd_ms: intervals.map(|spread| spread.sd_ms),
            interval_nonpositive: share(self.nonpositive, self.intervals.count()),
            punctual: share(self.punctual, count),
            late_p99_ms: late.p99_ms,
            late_max_ms: late.max_ms,
            missed: self.missed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_punctual_to_a_tenth_of_a_millisecond_and_missed_from_h_on() {
        let mut count = TickCount::new(1_000_000);
        for (k, late_ns) in [0, 100_000, 100_001, 999_999, 1_000_000]
            .into_iter()
            .enumerate()
        {
            let t_due_ns = 1_000_000 * k as u64;
            let t_tick_ns = t_due_ns + late_ns;
            count.push(&TickRow {
                k: k as u64,
                t_due_ns,
                t_tick_ns,
                u: 0.0,
                y: 0.0,
                seq: None,
                u_applied: None,
            });
        }
        let ticks = count.finish();
        assert_eq!(
            (ticks.count, ticks.punctual, ticks.missed),
            (5, Some(0.4), 1)
        );
        assert_eq!((ticks.late_max_ms, ticks.late_p99_ms), (Some(1.0), None));
        // Four intervals from 0 to 4 + 1 = 5 ms.
        assert_eq!(ticks.interval_avg_ms, Some(1.25));
        assert_eq!(ticks.interval_nonpositive, Some(0.0));
    }

    #[test]
    fn an_interval_is_nonpositive_where_the_clock_stood_still_or_went_back() {
        let mut count = TickCount::new(1_000_000);
        for (k, t_tick_ns) in [5, 6, 6, 4, 9].into_iter().enumerate() {
            count.push(&TickRow {
                k: k as u64,
                t_due_ns: 0,
                t_tick_ns,
                u: 0.0,
                y: 0.0,
                seq: None,
                u_applied: None,
            });
        }
        assert_eq!(count.finish().interval_nonpositive, Some(0.5));
    }
}
