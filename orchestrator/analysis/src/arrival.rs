//! Metrics of the arrivals at the plant (`arrivals.csv`): intervals and order. Lateness against the
//! schedule is in [`crate::lateness`], histograms are in [`crate::interval`].

use endpoint::ArrivalRow;
use serde::{Deserialize, Serialize};

use crate::lateness::{Drift, DriftCount};
use crate::statistics::{Moments, ms_between, share};

const MS_NS: u64 = 1_000_000;

/// Metrics of the arrivals. An interval is the time between two consecutive arrivals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Arrivals {
    /// Number of messages that arrived.
    pub count: u64,
    /// Mean interval, ms: the control interval of Fig. 8 and 9.
    pub interval_avg_ms: Option<f64>,
    /// Standard deviation of the intervals, ms.
    pub interval_sd_ms: Option<f64>,
    /// Share of intervals that are as asked for: within 10 % of h.
    pub interval_at_h: Option<f64>,
    /// Share of intervals that are zero in ns: Table 3, "at the same time as the previous packet".
    /// This share depends on the clock's resolution, so the next two fields give it for coarser ones;
    /// the paper's value fits timestamps of 10 ms.
    pub zero_exact: Option<f64>,
    /// Share of consecutive arrivals in the same millisecond.
    pub zero_1ms: Option<f64>,
    /// Share of consecutive arrivals in the same ten milliseconds.
    pub zero_10ms: Option<f64>,
    /// Share of consecutive arrivals in the same tick of the plant: the first of the two never takes
    /// effect.
    pub zero_tick: Option<f64>,
    /// Messages that arrived after one with a higher `seq`.
    pub out_of_order: u64,
    /// Lateness against the schedule.
    pub drift: Drift,
}

/// Accumulates [`Arrivals`] row by row.
#[derive(Debug)]
pub(crate) struct ArrivalCount {
    h_ns: u64,
    last: Option<ArrivalRow>,
    count: u64,
    intervals: Moments,
    at_h: u64,
    same: [u64; 4],
    newest: u64,
    out_of_order: u64,
    drift: DriftCount,
}

impl ArrivalCount {
    pub(crate) fn new(h_ns: u64) -> Self {
        Self {
            h_ns,
            last: None,
            count: 0,
            intervals: Moments::default(),
            at_h: 0,
            same: [0; 4],
            newest: 0,
            out_of_order: 0,
            drift: DriftCount::new(h_ns),
        }
    }

    pub(crate) fn push(&mut self, row: &ArrivalRow) {
        self.count += 1;
        if let Some(last) = &self.last {
            self.intervals
                .push(ms_between(last.t_arrive_ns, row.t_arrive_ns));
            let interval_ns = row.t_arrive_ns.saturating_sub(last.t_arrive_ns);
            self.at_h += u64::from(interval_ns.abs_diff(self.h_ns) <= self.h_ns / 10);
            let within = |ns: u64| last.t_arrive_ns / ns == row.t_arrive_ns / ns;
            let same = [
                within(1),
                within(MS_NS),
                within(10 * MS_NS),
                last.tick == row.tick,
            ];
            for (count, same) in self.same.iter_mut().zip(same) {
                *count += u64::from(same);
            }
        }
        self.out_of_order += u64::from(row.seq < self.newest);
        self.newest = self.newest.max(row.seq);
        self.drift.push(row);
        self.last = Some(*row);
    }

    pub(crate) fn finish(self) -> Arrivals {
        let intervals = self.intervals.spread();
        let zero = |which: usize| share(self.same[which], self.intervals.count());
        Arrivals {
            count: self.count,
            interval_avg_ms: intervals.map(|spread| spread.avg_ms),
            interval_sd_ms: intervals.map(|spread| spread.sd_ms),
            interval_at_h: share(self.at_h, self.intervals.count()),
            zero_exact: zero(0),
            zero_1ms: zero(1),
            zero_10ms: zero(2),
            zero_tick: zero(3),
            out_of_order: self.out_of_order,
            drift: self.drift.finish(),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use endpoint::ArrivalOutcome;

    /// Rows with these `seq` and arrival times, of a plant whose tick 0 was at time 0.
    pub(crate) fn rows(
        h_ns: u64,
        arrivals: impl IntoIterator<Item = (u64, u64)>,
    ) -> impl Iterator<Item = ArrivalRow> {
        let numbered = (0..).zip(arrivals);
        numbered.map(move |(n, (seq, t_arrive_ns))| ArrivalRow {
            n,
            seq,
            t_send_ns: Some(0),
            t_arrive_ns,
            tick: t_arrive_ns / h_ns,
            u: 0.0,
            outcome: ArrivalOutcome::Acknowledged,
        })
    }

    fn arrivals(h_ns: u64, of: impl IntoIterator<Item = (u64, u64)>) -> Arrivals {
        let mut count = ArrivalCount::new(h_ns);
        for row in rows(h_ns, of) {
            count.push(&row);
        }
        count.finish()
    }

    #[test]
    fn an_interval_is_at_h_within_a_tenth_of_it() {
        // Gaps of 9, 11, 8.9, 11.1 and 0 ms, with h = 10 ms.
        let times_us = [0, 9_000, 20_000, 28_900, 40_000, 40_000];
        let a = arrivals(10_000_000, (0..).zip(times_us.map(|us| us * 1000)));
        assert_eq!(a.interval_at_h, Some(0.4));
        assert_eq!(a.interval_avg_ms, Some(8.0));
    }

    #[test]
    fn table_3_counts_the_messages_that_came_with_the_one_before() {
        // A blocking client of 2011 with timestamps of 10 ms: 2 of 2001 messages in 600 s give 0.0010.
        let at = |k: u64| {
            k * 300_000_000
                - if k % 1000 == 7 {
                    300_000_000 - 4_000_000
                } else {
                    0
                }
        };
        let a = arrivals(300_000_000, (0..2001).map(|k| (k, at(k))));
        assert_eq!((a.zero_exact, a.zero_1ms), (Some(0.0), Some(0.0)));
        assert_eq!(a.zero_10ms, Some(0.001));
    }

    #[test]
    fn zero_intervals_depend_on_the_clock_that_is_read() {
        // Gaps of 0, 0.4 and 3 ms, all from the start of a 10 ms grid; three arrivals share one tick
        // of 1 ms.
        let a = arrivals(1_000_000, [(0, 0), (1, 0), (2, 400_000), (3, 3_400_000)]);
        assert_eq!(
            (a.zero_exact, a.zero_1ms),
            (Some(1.0 / 3.0), Some(2.0 / 3.0))
        );
        assert_eq!((a.zero_10ms, a.zero_tick), (Some(1.0), Some(2.0 / 3.0)));
    }

    #[test]
    fn a_message_is_out_of_order_when_a_later_one_came_first() {
        let a = arrivals(1_000_000, [(0, 0), (3, 1), (1, 2), (2, 3), (4, 4)]);
        assert_eq!((a.count, a.out_of_order), (5, 2));
    }

    #[test]
    fn nothing_arrived_and_nothing_is_said() {
        let a = arrivals(1_000_000, []);
        assert_eq!(
            (a.count, a.interval_avg_ms, a.zero_1ms, a.interval_at_h),
            (0, None, None, None)
        );
        assert_eq!(a.drift, Drift::default());
    }
}
