//! The clocks of this machine, in integer nanoseconds. Waiting on them is left to others.

use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;

/// The run's clock now, in nanoseconds of `CLOCK_MONOTONIC`: the same in every process and namespace of this
/// machine. On common machines this is not a system call.
#[must_use]
#[inline]
pub fn now_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::Monotonic))
}

/// The wall clock now, in nanoseconds since 1970. It may step, so nothing is measured by it: it is for stamps that
/// the kernel gives on no other clock.
#[must_use]
#[inline]
pub fn wall_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::Realtime))
}

/// One clock counts from boot, and the kernel sets the other to no time before 1970: both parts are positive, and
/// 584 years fit.
#[inline]
fn nanoseconds(time: Timespec) -> u64 {
    time.tv_sec.cast_unsigned() * SECOND_NS + time.tv_nsec.cast_unsigned()
}

/// An instant of a clock, or a time span, in the kernel's form.
#[must_use]
#[inline]
pub fn timespec(ns: u64) -> Timespec {
    Timespec {
        // At most 2^64 / 10^9, far below 2^63.
        tv_sec: (ns / SECOND_NS).cast_signed(),
        tv_nsec: (ns % SECOND_NS).cast_signed(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instant_keeps_all_its_nanoseconds() {
        let time = timespec(7_000_000_003);
        assert_eq!((time.tv_sec, time.tv_nsec), (7, 3));
        assert_eq!(nanoseconds(time), 7_000_000_003);
    }
}
