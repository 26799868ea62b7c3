//! What arrived at the plant, and when (`arrivals.csv`): intervals, order, and the slope of Fig. 3.

use endpoint::ArrivalRow;
use serde::{Deserialize, Serialize};

use crate::statistics::{Line, Moments, ms_between, share};

const MS_NS: u64 = 1_000_000;

/// Messages in order of arrival; an interval is the time between two neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Arrivals {
    /// Messages that arrived.
    pub count: u64,
    /// Mean interval, ms: the control interval of Fig. 8 and 9.
    pub interval_avg_ms: Option<f64>,
    /// Standard deviation of the intervals, ms.
    pub interval_sd_ms: Option<f64>,
    /// Share of intervals that are zero in ns. "At the same time" depends on the clock, hence this
    /// and the next two; the paper's Table 3 fits stamps of 10 ms.
    pub zero_exact: Option<f64>,
    /// Share of neighbours in the same millisecond.
    pub zero_1ms: Option<f64>,
    /// Share of neighbours in the same ten milliseconds.
    pub zero_10ms: Option<f64>,
    /// Share of neighbours in the same tick of the plant: the first of the two never acts.
    pub zero_tick: Option<f64>,
    /// Messages that a later one had overtaken.
    pub out_of_order: u64,
    /// Slope, s/s, of the lateness `(a_k - a_0) - k h` over k h (Fig. 3 and 4): 0 keeps the schedule.
    pub slope: Option<f64>,
    /// The lateness of the last arrival against the first, s.
    pub lag_s: Option<f64>,
}

/// Arrivals under way.
#[derive(Debug)]
pub(crate) struct ArrivalCount {
    h_ns: u64,
    first: Option<ArrivalRow>,
    last: Option<ArrivalRow>,
    count: u64,
    intervals: Moments,
    same: [u64; 4],
    newest: u64,
    out_of_order: u64,
    lateness: Line,
}

impl ArrivalCount {
    pub(crate) fn new(h_ns: u64) -> Self {
        Self {
            h_ns,
            first: None,
            last: None,
            count: 0,
            intervals: Moments::default(),
            same: [0; 4],
            newest: 0,
            out_of_order: 0,
            lateness: Line::default(),
        }
    }

    pub(crate) fn push(&mut self, row: &ArrivalRow) {
        let first = *self.first.get_or_insert(*row);
        self.count += 1;
        if let Some(last) = &self.last {
            self.intervals
                .push(ms_between(last.t_arrive_ns, row.t_arrive_ns));
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
        self.lateness
            .push(self.schedule_s(row.seq), self.late_s(&first, row));
        self.last = Some(*row);
    }

    /// k h, s.
    fn schedule_s(&self, seq: u64) -> f64 {
        seq as f64 * self.h_ns as f64 / 1e9
    }

    /// How much later than the first, and than its place in the schedule says, `row` arrived, s.
    fn late_s(&self, first: &ArrivalRow, row: &ArrivalRow) -> f64 {
        let arrived_s = ms_between(first.t_arrive_ns, row.t_arrive_ns) / 1e3;
        arrived_s - (self.schedule_s(row.seq) - self.schedule_s(first.seq))
    }

    pub(crate) fn finish(self) -> Arrivals {
        let intervals = self.intervals.spread();
        let zero = |which: usize| share(self.same[which], self.intervals.count());
        Arrivals {
            count: self.count,
            interval_avg_ms: intervals.map(|spread| spread.avg_ms),
            interval_sd_ms: intervals.map(|spread| spread.sd_ms),
            zero_exact: zero(0),
            zero_1ms: zero(1),
            zero_10ms: zero(2),
            zero_tick: zero(3),
            out_of_order: self.out_of_order,
            slope: self.lateness.slope(),
            lag_s: self
                .first
                .zip(self.last)
                .map(|(first, last)| self.late_s(&first, &last)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use endpoint::ArrivalOutcome;

    fn arrivals(h_ns: u64, rows: impl IntoIterator<Item = (u64, u64)>) -> Arrivals {
        let mut count = ArrivalCount::new(h_ns);
        for (n, (seq, t_arrive_ns)) in rows.into_iter().enumerate() {
            let outcome = ArrivalOutcome::Acknowledged;
            let tick = t_arrive_ns / h_ns;
            count.push(&ArrivalRow {
                n: n as u64,
                seq,
                t_send_ns: 0,
                t_arrive_ns,
                tick,
                u: 0.0,
                outcome,
            });
        }
        count.finish()
    }

    #[test]
    fn a_client_that_takes_ten_point_nine_ms_for_ten_drifts_as_the_paper_s_javascript() {
        // (10.9 - 10)/10 = 0.09 s/s; after 55 000 messages, 599.5 s, it is 49.5 s late.
        let late = arrivals(
            10_000_000,
            (0..55_001).map(|k| (k, 7_000_000_000 + k * 10_900_000)),
        );
        assert!((late.slope.expect("many") - 0.09).abs() < 1e-9);
        assert!((late.lag_s.expect("many") - 49.5).abs() < 1e-6);
        assert!((late.interval_avg_ms.expect("many") - 10.9).abs() < 1e-9);
        assert!(late.interval_sd_ms.expect("many") < 1e-6);
    }

    #[test]
    fn zero_intervals_depend_on_the_clock_that_is_read() {
        // Gaps of 0, 0.4 and 3 ms, all from the start of a 10 ms grid; one tick of 1 ms holds
        // three.
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
            (a.count, a.interval_avg_ms, a.zero_1ms, a.slope, a.lag_s),
            (0, None, None, None, None)
        );
    }
}
