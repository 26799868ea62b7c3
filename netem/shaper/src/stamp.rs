//! Stamps that the kernel gives packets as it receives them, converted to the run's clock.

use clock::now::{SECOND_NS, now_ns, wall_ns};

/// The longest that a packet may plausibly have waited in a socket. A stamp that is older than this
/// indicates a step of the wall clock.
const OLDEST_STAMP_NS: u64 = 2 * SECOND_NS;

/// Converts the kernel's receive stamps, which are wall-clock time, to the monotonic clock.
///
/// The difference between the clocks is sampled at each reading, one for packets that were taken together, so
/// slewing does no harm, and a step of the wall clock affects only packets that are in the socket at that time. Each stamp is
/// therefore converted with the difference now and with the one before. The younger of the plausible
/// times is used, since the other one contains the step; if neither is plausible, the packet counts
/// as received now. No time is ever in the future or older than two seconds.
#[derive(Debug)]
pub(crate) struct StampClock {
    wall_minus_monotonic_ns: u64,
}

impl StampClock {
    pub(crate) fn new() -> Self {
        Self {
            wall_minus_monotonic_ns: wall_minus_monotonic_ns(),
        }
    }

    /// The monotonic time of the wall-clock `stamp_ns`, which has just been read.
    pub(crate) fn monotonic_ns(&mut self, stamp_ns: u64) -> u64 {
        self.read().monotonic_ns(Some(stamp_ns))
    }

    /// Reads the clocks, for stamps that have just been read.
    pub(crate) fn read(&mut self) -> Reading {
        let distance_before_ns = self.wall_minus_monotonic_ns;
        self.wall_minus_monotonic_ns = wall_minus_monotonic_ns();
        Reading {
            distance_ns: self.wall_minus_monotonic_ns,
            distance_before_ns,
            now_ns: now_ns(),
        }
    }
}

/// A reading of both clocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    distance_ns: u64,
    distance_before_ns: u64,
    now_ns: u64,
}

impl Reading {
    /// The monotonic time of a wall-clock stamp from before this reading; of one that is missing, now.
    pub(crate) fn monotonic_ns(self, stamp_ns: Option<u64>) -> u64 {
        stamp_ns.map_or(self.now_ns, |stamp_ns| {
            settle(
                stamp_ns,
                self.distance_ns,
                self.distance_before_ns,
                self.now_ns,
            )
        })
    }
}

/// The difference between the clocks, from three consecutive readings: monotonic, wall, monotonic. If
/// the first and the last are far apart, this thread was interrupted between them, and the readings
/// are repeated. Wrapping, because the wall clock of a machine without a battery starts near zero.
fn wall_minus_monotonic_ns() -> u64 {
    /// Three readings without interruption take well under this.
    const UNDISTURBED_NS: u64 = 1_000;
    /// If the readings are interrupted this often in a row, the best of them is used.
    const TRIES: usize = 4;
    let mut best = (u64::MAX, 0);
    for _ in 0..TRIES {
        let (before, wall, after) = (now_ns(), wall_ns(), now_ns());
        let span = after - before;
        if span < best.0 {
            best = (span, wall.wrapping_sub(before + span / 2));
        }
        if span <= UNDISTURBED_NS {
            break;
        }
    }
    best.1
}

/// Rounding of the clock readings may put a stamp this far into the future.
const ROUNDING_NS: u64 = 10_000;

fn settle(stamp_ns: u64, distance_ns: u64, distance_before_ns: u64, now_ns: u64) -> u64 {
    [distance_ns, distance_before_ns]
        .into_iter()
        .map(|distance| stamp_ns.wrapping_sub(distance))
        .filter(|&time| {
            let oldest = now_ns.saturating_sub(OLDEST_STAMP_NS);
            (oldest..=now_ns + ROUNDING_NS).contains(&time)
        })
        .max()
        .unwrap_or(now_ns)
        .min(now_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: u64 = 100 * SECOND_NS;
    const DISTANCE: u64 = 1_700_000_000 * SECOND_NS;

    #[test]
    fn a_stamp_in_quiet_times_keeps_its_age() {
        let stamp = NOW + DISTANCE - 35_000;
        assert_eq!(settle(stamp, DISTANCE, DISTANCE, NOW), NOW - 35_000);
    }

    #[test]
    fn a_packet_that_waits_while_the_wall_clock_steps_keeps_its_age() {
        // Stamped before the step and read after it; steps of an hour and of half a second, which
        // would otherwise be mistaken for a plausible age.
        let stamp = NOW + DISTANCE - 35_000;
        for step in [3_600 * SECOND_NS, SECOND_NS / 2] {
            for after in [DISTANCE + step, DISTANCE - step] {
                assert_eq!(settle(stamp, after, DISTANCE, NOW), NOW - 35_000);
            }
        }
    }

    #[test]
    fn a_stamp_that_fits_no_clock_counts_as_now() {
        assert_eq!(settle(5, DISTANCE, DISTANCE, NOW), NOW);
        assert_eq!(settle(u64::MAX, DISTANCE, DISTANCE, NOW), NOW);
    }

    #[test]
    fn a_wall_clock_behind_the_monotonic_one_is_no_trouble() {
        // No battery: the wall clock reads 3 s when the machine has been up for 100 s.
        let distance = (3 * SECOND_NS).wrapping_sub(NOW);
        assert_eq!(
            settle(3 * SECOND_NS - 20_000, distance, distance, NOW),
            NOW - 20_000
        );
    }

    #[test]
    fn the_distance_between_the_clocks_is_steady_to_microseconds() {
        // Two samples in quick succession, on a machine whose clock is slewed by at most 500 ppm and
        // which interrupts this thread now and then: the generous limit is 1 ms.
        let first = wall_minus_monotonic_ns();
        let second = wall_minus_monotonic_ns();
        assert!(first.wrapping_sub(second).cast_signed().abs() < 1_000_000);
    }
}
