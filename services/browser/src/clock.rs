//! The difference between a page's clock and the run's.
//!
//! A page knows the time of day at which it began, and the time since then. The run's clock is
//! `CLOCK_MONOTONIC`. On one machine the difference is constant as long as nobody sets the system time.

use rustix::time::{ClockId, clock_gettime};

const NS_PER_S: i64 = 1_000_000_000;

/// How often both clocks are read. The fastest reading counts, since nothing interrupted it.
const READINGS: u32 = 32;

/// `CLOCK_REALTIME` - `CLOCK_MONOTONIC` in nanoseconds; 0 if the time of day is before the machine's
/// start, which happens only with a clock that was never set.
pub(crate) fn clock_ns() -> u64 {
    (0..READINGS)
        .map(|_| {
            let before_ns = read(ClockId::Monotonic);
            let real_ns = read(ClockId::Realtime);
            let gap_ns = read(ClockId::Monotonic) - before_ns;
            (gap_ns, real_ns - before_ns - gap_ns / 2)
        })
        .min()
        .and_then(|(_, difference_ns)| u64::try_from(difference_ns).ok())
        .unwrap_or_default()
}

fn read(clock: ClockId) -> i64 {
    let time = clock_gettime(clock);
    time.tv_sec.saturating_mul(NS_PER_S) + time.tv_nsec
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_makes_the_time_of_day_the_time_of_the_run() {
        let clock_ns = i64::try_from(clock_ns()).expect("it fits");
        let apart_ns = read(ClockId::Realtime) - clock_ns - read(ClockId::Monotonic);
        // The two readings here may be this far apart on a busy machine.
        assert!(apart_ns.abs() < NS_PER_S, "{apart_ns} ns");
    }
}
