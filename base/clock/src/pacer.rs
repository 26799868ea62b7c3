//! Waiting for an instant of the run's clock, in a thread. A task has an alarm for it.

use rustix::{thread::clock_nanosleep_absolute, time::ClockId};

use crate::guard::Guard;
use crate::now::{now_ns, timespec};
use crate::scheduling::Granted;

/// Waits for deadlines.
#[derive(Clone, Debug)]
pub struct Pacer {
    guard: Guard,
}

impl Pacer {
    /// A pacer for a thread that was granted this: a real-time thread wakes a learnt time before a deadline, and
    /// spins. An ordinary thread only sleeps: spinning would use up its processor share just when it needs it,
    /// and was measured to be worse than sleeping.
    #[must_use]
    pub fn new(granted: &Granted) -> Self {
        let guard = Guard::of(granted);
        Self { guard }
    }

    /// Returns at `due_ns`, or as soon after it as the kernel permits; at once if that has passed.
    pub fn sleep_until(&mut self, due_ns: u64) {
        let now = now_ns();
        let wake_ns = self.guard.wake_rested_ns(now, due_ns);
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

    #[test]
    fn a_wait_never_ends_before_its_deadline_and_a_past_one_does_not_wait() {
        let fifo = Granted {
            fifo_priority: Some(1),
            ..Granted::ordinary()
        };
        for granted in [Granted::ordinary(), fifo] {
            let mut pacer = Pacer::new(&granted);
            let due_ns = now_ns() + 3_000_000;
            pacer.sleep_until(due_ns);
            assert!(now_ns() >= due_ns);
            pacer.sleep_until(0);
        }
    }
}
