//! Histograms of the intervals between arrivals, in ms and in the plant's ticks (Fig. 8 and 9).
//!
//! The bins in ms depend only on h, so that cells of one rate can be added and compared. Up to 20.5 h
//! each bin of full width is centred on a multiple of its width, so that a peak at h is one bin and
//! not two halves.
//!
//! - up to 4.025 h, bins are h/20 wide; the first has half that width and is for intervals of zero;
//! - up to 20.5 h, they are h wide, except the first, from 4.025 h to 4.5 h;
//! - up to 100.5 h, they are 10 h wide;
//! - the last has no upper bound.

use std::collections::BTreeMap;
use std::path::Path;

use endpoint::ArrivalRow;
use plan::file_name;
use record::ReadError;
use record::rows::read;

use crate::statistics::ms;

/// Histograms of the intervals of one cell.
#[derive(Debug)]
pub struct Intervals {
    /// Where each bin ends and the next begins, ns; the last bin has no end.
    ends_ns: Vec<u64>,
    counts: Vec<u64>,
    ticks: BTreeMap<u64, u64>,
    last: Option<ArrivalRow>,
}

/// One bin: `from_ms <= interval < to_ms`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Lower bound, ms.
    pub from_ms: f64,
    /// Upper bound, ms; `None` for the last bin.
    pub to_ms: Option<f64>,
    /// Number of intervals in the bin.
    pub count: u64,
}

impl Intervals {
    /// Reads the arrivals in a cell's folder.
    ///
    /// # Errors
    /// [`ReadError`] if `arrivals.csv` cannot be read.
    pub fn read(folder: &Path, h_ns: u64) -> Result<Self, ReadError> {
        let mut intervals = Self::new(h_ns);
        let path = folder.join(file_name::ARRIVALS);
        read(&path, |row| intervals.push(row))?;
        Ok(intervals)
    }

    fn new(h_ns: u64) -> Self {
        let fine = (0..=80).map(|n| (2 * n + 1, 40));
        let by_h = (4..=20).map(|n| (2 * n + 1, 2));
        let by_ten = (30..=100).step_by(10).map(|n| (2 * n + 1, 2));
        let ends_ns: Vec<u64> = fine
            .chain(by_h)
            .chain(by_ten)
            .map(|(times, of)| h_ns.saturating_mul(times) / of)
            .collect();
        Self {
            counts: vec![0; ends_ns.len() + 1],
            ends_ns,
            ticks: BTreeMap::new(),
            last: None,
        }
    }

    fn push(&mut self, row: &ArrivalRow) {
        if let Some(last) = self.last.replace(*row) {
            let interval_ns = row.t_arrive_ns.saturating_sub(last.t_arrive_ns);
            let bin = self.ends_ns.partition_point(|end| *end <= interval_ns);
            self.counts[bin] += 1;
            let ticks = row.tick.saturating_sub(last.tick);
            *self.ticks.entry(ticks).or_default() += 1;
        }
    }

    /// All bins in ms, in ascending order, including the empty ones.
    pub fn bins(&self) -> impl Iterator<Item = Bin> {
        self.counts.iter().enumerate().map(|(i, count)| Bin {
            from_ms: i.checked_sub(1).map_or(0.0, |i| ms(self.ends_ns[i])),
            to_ms: self.ends_ns.get(i).copied().map(ms),
            count: *count,
        })
    }

    /// How often the plant made n ticks between two arrivals, as pairs of n and its count, in
    /// ascending order of n; only those that occurred. Of two arrivals in one tick the first never
    /// takes effect.
    pub fn ticks(&self) -> impl Iterator<Item = (u64, u64)> {
        self.ticks.iter().map(|(ticks, count)| (*ticks, *count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrival::tests::rows;
    use proptest::prelude::*;

    const H_NS: u64 = 3_000_000;

    fn intervals(times_ns: impl IntoIterator<Item = u64>) -> Intervals {
        let mut intervals = Intervals::new(H_NS);
        for row in rows(H_NS, times_ns.into_iter().map(|t| (0, t))) {
            intervals.push(&row);
        }
        intervals
    }

    #[test]
    fn a_peak_at_a_multiple_of_h_is_in_the_middle_of_one_bin() {
        // Gaps of 0, of 3 ms three times with 20 us of noise, of 6 ms, 13.4 ms and half a second.
        let gaps_us = [0, 3000, 2980, 3020, 6000, 13_400, 500_000];
        let times = gaps_us.iter().scan(0, |t, gap| {
            *t += gap * 1000;
            Some(*t)
        });
        let filled: Vec<_> = intervals([0].into_iter().chain(times))
            .bins()
            .filter(|bin| bin.count > 0)
            .map(|bin| (bin.from_ms, bin.to_ms, bin.count))
            .collect();
        assert_eq!(
            filled,
            [
                (0.0, Some(0.075), 1),
                (2.925, Some(3.075), 3),
                (5.925, Some(6.075), 1),
                (12.075, Some(13.5), 1),
                (301.5, None, 1),
            ]
        );
    }

    #[test]
    fn ticks_are_counted_as_the_plant_saw_them() {
        let intervals = intervals([0, 1_000_000, 3_000_000, 9_000_000, 9_000_001]);
        let ticks: Vec<_> = intervals.ticks().collect();
        assert_eq!(ticks, [(0, 2), (1, 1), (2, 1)]);
    }

    proptest! {
        #[test]
        fn every_interval_is_in_one_bin_and_bins_leave_no_gap(
            gaps in prop::collection::vec(0u64..400_000_000, 1..200), h_ns in 10_000u64..1_000_000_000,
        ) {
            let mut intervals = Intervals::new(h_ns);
            let times = gaps.iter().scan(0, |t, gap| { *t += gap; Some(*t) });
            for row in rows(h_ns, [0].into_iter().chain(times).map(|t| (0, t))) {
                intervals.push(&row);
            }
            let bins: Vec<Bin> = intervals.bins().collect();
            prop_assert_eq!(bins.iter().map(|bin| bin.count).sum::<u64>(), gaps.len() as u64);
            prop_assert_eq!(intervals.ticks().map(|(_, count)| count).sum::<u64>(), gaps.len() as u64);
            for pair in bins.windows(2) {
                prop_assert_eq!(pair[0].to_ms, Some(pair[1].from_ms));
                prop_assert!(pair[0].from_ms < pair[1].from_ms);
            }
            for bin in &bins {
                let inside = |gap: &&u64| ms(**gap) >= bin.from_ms && bin.to_ms.is_none_or(|to| ms(**gap) < to);
                prop_assert_eq!(gaps.iter().filter(inside).count() as u64, bin.count);
            }
        }
    }
}
