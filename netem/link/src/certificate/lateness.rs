//! How late the player's packets left: a histogram of fixed size, so that each entry costs the same
//! few instructions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Buckets per doubling, so that a quantile is exact to a sixteenth, 6.25 %.
const STEPS: u64 = 16;
/// Sixteen buckets for each doubling of a 64-bit number, and one bucket each for the values below 16 ns.
const BUCKETS: usize = (STEPS * (64 - STEPS.ilog2() as u64 + 1)) as usize;

/// Counts of lateness, in nanoseconds.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u64; BUCKETS]>,
    count: u64,
    sum_ns: u64,
    max_ns: u64,
}

/// A histogram in five numbers, microseconds each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lateness {
    /// Mean lateness, in µs.
    pub mean_us: f64,
    /// Half of the packets were at most this late.
    pub p50_us: f64,
    /// 99 of 100 packets were at most this late.
    pub p99_us: f64,
    /// 999 of 1000 packets were at most this late.
    pub p999_us: f64,
    /// The latest one.
    pub max_us: f64,
}

const US_PER_NS: f64 = 1e-3;

impl Default for Histogram {
    fn default() -> Self {
        Self::new()
    }
}

impl Histogram {
    /// An empty histogram.
    #[must_use]
    pub fn new() -> Self {
        Self {
            counts: Box::new([0; BUCKETS]),
            count: 0,
            sum_ns: 0,
            max_ns: 0,
        }
    }

    /// Counts a lateness of `ns` nanoseconds, so many times.
    pub fn add(&mut self, ns: u64, times: u64) {
        self.counts[bucket(ns)] += times;
        self.count += times;
        self.sum_ns = self.sum_ns.saturating_add(ns.saturating_mul(times));
        self.max_ns = self.max_ns.max(ns);
    }

    /// The histogram in five numbers; zeros if it is empty.
    #[must_use]
    pub fn summary(&self) -> Lateness {
        if self.count == 0 {
            return Lateness::default();
        }
        Lateness {
            mean_us: self.sum_ns as f64 / self.count as f64 * US_PER_NS,
            p50_us: self.quantile_us(500),
            p99_us: self.quantile_us(990),
            p999_us: self.quantile_us(999),
            max_us: self.max_ns as f64 * US_PER_NS,
        }
    }

    /// The upper edge of the bucket in which the count reaches this many thousandths, but at most the
    /// maximum.
    fn quantile_us(&self, thousandths: u64) -> f64 {
        let needed = (self.count * thousandths).div_ceil(1000).max(1);
        let mut seen = 0;
        for (index, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= needed {
                return upper_edge_ns(index).min(self.max_ns) as f64 * US_PER_NS;
            }
        }
        self.max_ns as f64 * US_PER_NS
    }
}

/// Below `STEPS` each value has its own bucket; above, the position of the highest bit and the four
/// bits after it give the bucket.
fn bucket(ns: u64) -> usize {
    let octave = (ns | (STEPS - 1)).ilog2() - (STEPS.ilog2() - 1);
    let step = if octave == 0 {
        ns
    } else {
        (ns >> (octave - 1)) - STEPS
    };
    (u64::from(octave) * STEPS + step) as usize
}

/// The largest value that falls into the bucket.
fn upper_edge_ns(index: usize) -> u64 {
    let (octave, step) = (index as u64 / STEPS, index as u64 % STEPS);
    if octave == 0 {
        return step;
    }
    // In u128, because the edge of the last bucket is one below 2^64.
    let above = u128::from(STEPS + step + 1) << (octave - 1);
    u64::try_from(above - 1).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_empty_histogram_is_all_zeros() {
        assert_eq!(Histogram::new().summary(), Lateness::default());
    }

    proptest! {
        /// A bucket spans a sixteenth of its lower edge, so its upper edge is at most 1/16
        /// above any value in it.
        #[test]
        fn a_value_lies_in_its_bucket_and_the_bucket_is_narrow(ns in any::<u64>(), shift in 0_u32..64) {
            let ns = ns >> shift;
            let index = bucket(ns);
            prop_assert!(index < BUCKETS);
            let edge = upper_edge_ns(index);
            prop_assert!(edge >= ns);
            prop_assert!(edge - ns <= ns / STEPS);
            prop_assert!(index == 0 || upper_edge_ns(index - 1) < ns);
        }

        /// Quantiles of the histogram against those of the sorted values.
        #[test]
        fn quantiles_are_the_sorted_values_to_a_sixteenth(
            mut values in prop::collection::vec(0_u64..10_000_000, 1..500),
        ) {
            let mut histogram = Histogram::new();
            values.iter().for_each(|&ns| histogram.add(ns, 1));
            values.sort_unstable();
            let summary = histogram.summary();
            for (thousandths, told_us) in [(500, summary.p50_us), (990, summary.p99_us), (999, summary.p999_us)] {
                let exact = values[(values.len() * thousandths).div_ceil(1000) - 1] as f64 * US_PER_NS;
                prop_assert!(told_us >= exact - 1e-9 && told_us <= exact * (1.0 + 1.0 / 16.0) + 1e-9);
            }
            prop_assert_eq!(summary.max_us, values[values.len() - 1] as f64 * US_PER_NS);
        }
    }
}
