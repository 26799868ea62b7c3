//! The run's clock in integer nanoseconds, and waiting for an instant on it.

use rustix::{
    thread::clock_nanosleep_absolute,
    time::{ClockId, Timespec, clock_gettime},
};

use endpoint::report::Scheduling;

use crate::guard::Guard;

const NS_PER_S: u64 = 1_000_000_000;

/// The time now, in nanoseconds of `CLOCK_MONOTONIC`. On common machines this is not a system call.
#[must_use]
pub fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    // Monotonic time starts at boot: both parts are positive, and 584 years fit.
    now.tv_sec.cast_unsigned() * NS_PER_S + now.tv_nsec.cast_unsigned()
}

/// An instant of the run's clock in the kernel's form.
#[must_use]
pub fn timespec(t_ns: u64) -> Timespec {
    Timespec {
        // At most 2^64 / 10^9, far below 2^63.
        tv_sec: (t_ns / NS_PER_S).cast_signed(),
        tv_nsec: (t_ns % NS_PER_S).cast_signed(),
    }
}

/// Waits for deadlines.
#[derive(Clone, Debug)]
pub struct Pacer {
    guard: Guard,
}

impl Pacer {
    /// A pacer for a thread with this scheduling: a real-time thread wakes a learnt time before a deadline, and
    /// spins. An ordinary thread only sleeps: spinning would use up its processor share just when it needs it,
    /// and was measured to be worse than sleeping.
    #[must_use]
    pub fn new(scheduling: &Scheduling) -> Self {
        let guard = Guard::of(scheduling);
        Self { guard }
    }

    /// Returns at `due_ns`, or as soon after it as the kernel permits; at once if that has passed.
    pub fn sleep_until(&mut self, due_ns: u64) {
        let now = now_ns();
        let wake_ns = self.guard.wake_ns(now, due_ns);
        if now < wake_ns {
            // The sleep returns early if a signal interrupts it, so the loop sleeps again.
            let wake = timespec(wake_ns);
            while clock_nanosleep_absolute(ClockId::Monotonic, &wake).is_err() && now_ns() < wake_ns
            {
            }
            self.guard.learn(now_ns().saturating_sub(wake_ns));
        }
        while now_ns() < due_ns {
            std::hint::spin_loop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use endpoint::report::Policy;

    #[test]
    fn a_wait_never_ends_before_its_deadline_and_a_past_one_does_not_wait() {
        let other = Scheduling::ordinary();
        let fifo = Scheduling {
            policy: Policy::Fifo,
            ..Scheduling::ordinary()
        };
        for scheduling in [other, fifo] {
            let mut pacer = Pacer::new(&scheduling);
            let due_ns = now_ns() + 3_000_000;
            pacer.sleep_until(due_ns);
            assert!(now_ns() >= due_ns);
            pacer.sleep_until(0);
        }
    }

    #[test]
    fn an_instant_keeps_all_its_nanoseconds() {
        let time = timespec(7_000_000_003);
        assert_eq!((time.tv_sec, time.tv_nsec), (7, 3));
    }
}
