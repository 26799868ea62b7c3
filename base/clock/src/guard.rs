//! How long before a deadline to wake, so that the deadline is met awake: learnt from how late earlier wakes
//! were. Pure. When to sleep, and on what, is left to who waits: the ends for an instant, a player of links for a
//! packet too.

use crate::scheduling::Granted;

/// The time before a deadline at which a real-time thread wakes, to spin until the deadline.
///
/// It follows the upper quantile of the lateness that one wake in fifty exceeds: so the thread hardly ever
/// misses its deadline, and spins hardly longer than a wake varies. It moves by a small step a wake, whatever
/// the lateness was, so a disturbance changes it little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Guard {
    ns: u64,
    most_ns: u64,
}

impl Guard {
    /// Near what waking a halted core takes on a virtual machine.
    const FIRST_NS: u64 = 50_000;

    /// The most, which at 1 kHz is a seventh of a core. A wake that was later teaches nothing: the thread, or
    /// the whole machine, was held up.
    const MOST_NS: u64 = 150_000;

    /// What a sleep takes at the least.
    const SHORT_NS: u64 = 15_000;

    /// One step up for fifty steps down: the quantile of 98 %.
    const UP_NS: u64 = 2_000;
    const DOWN_NS: u64 = 40;

    /// The guard of a thread that was granted this.
    #[must_use]
    pub fn of(granted: &Granted) -> Self {
        match granted.fifo_priority {
            Some(_) => Self::new(),
            None => Self::none(),
        }
    }

    /// A guard that learns.
    const fn new() -> Self {
        Self {
            ns: Self::FIRST_NS,
            most_ns: Self::MOST_NS,
        }
    }

    /// For a thread that only sleeps.
    const fn none() -> Self {
        Self { ns: 0, most_ns: 0 }
    }

    /// When to wake for a deadline, however short the wait is: all of the guard is awake. It is for the player of
    /// a link, whose lateness falls on every packet.
    #[must_use]
    #[inline]
    pub fn wake_ns(self, due_ns: u64) -> u64 {
        due_ns.saturating_sub(self.ns)
    }

    /// When to wake for a deadline, at `now_ns`: at least three quarters of the wait are slept. So a loop of 10 kHz
    /// leaves both cores of a small machine to what answers it. A wait that is shorter than a wake takes is
    /// not slept at all.
    #[must_use]
    #[inline]
    pub fn wake_rested_ns(self, now_ns: u64, due_ns: u64) -> u64 {
        let wait_ns = due_ns.saturating_sub(now_ns);
        if wait_ns <= Self::SHORT_NS && self.most_ns > 0 {
            return due_ns - wait_ns;
        }
        due_ns - self.ns.min(wait_ns / 4)
    }

    /// A wake was so late.
    #[inline]
    pub fn learn(&mut self, late_ns: u64) {
        if late_ns <= self.ns {
            self.ns = self.ns.saturating_sub(Self::DOWN_NS);
        } else if late_ns <= self.most_ns {
            self.ns = (self.ns + Self::UP_NS).min(self.most_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever it is told, it stays below its most, and one wake moves it by a step at most.
        #[test]
        fn it_is_bounded_and_moves_slowly(late_ns in prop::collection::vec(0_u64..400_000_000, 0..300)) {
            let (mut guard, mut none) = (Guard::new(), Guard::none());
            for late_ns in late_ns {
                let before = guard;
                guard.learn(late_ns);
                none.learn(late_ns);
                prop_assert!(guard.ns <= Guard::MOST_NS);
                prop_assert!(guard.ns.abs_diff(before.ns) <= Guard::UP_NS);
                prop_assert!(late_ns <= Guard::MOST_NS || guard == before, "a pause teaches nothing");
            }
            prop_assert_eq!(none, Guard::none());
        }

        /// Wakes that vary between any two bounds, with a pause of the machine now and then.
        #[test]
        fn one_wake_in_fifty_is_later(
            from_ns in 0_u64..100_000, width_ns in 5_000_u64..50_000, seed in any::<u32>(), every in 10_usize..1000,
        ) {
            let mut state = u64::from(seed) | 1;
            let mut late = |number: usize| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                if number.is_multiple_of(every) { 100_000_000 } else { from_ns + state % width_ns }
            };
            let mut guard = Guard::new();
            let mut beyond = 0;
            for number in 0..30_000 {
                let late_ns = late(number);
                if number >= 10_000 && late_ns > guard.ns && late_ns <= Guard::MOST_NS {
                    beyond += 1;
                }
                guard.learn(late_ns);
            }
            prop_assert!((200..=650).contains(&beyond), "{} of 20000, guard {}", beyond, guard.ns);
        }

        #[test]
        fn three_quarters_of_a_wait_are_slept_or_nothing_of_a_short_one(now_ns in 0_u64..1 << 40, wait_ns in 0_u64..1 << 40, ns in 0..=Guard::MOST_NS) {
            let guard = Guard { ns, ..Guard::new() };
            let due_ns = now_ns + wait_ns;
            let wake_ns = guard.wake_rested_ns(now_ns, due_ns);
            prop_assert!(wake_ns <= due_ns && due_ns - wake_ns <= ns.max(Guard::SHORT_NS));
            prop_assert!(guard.wake_ns(due_ns) == due_ns.saturating_sub(ns) && Guard::none().wake_ns(due_ns) == due_ns);
            prop_assert!(wake_ns - now_ns >= wait_ns / 4 * 3 || wait_ns <= Guard::SHORT_NS);
            prop_assert_eq!(Guard::none().wake_rested_ns(now_ns, due_ns), due_ns);
            // A deadline that has passed is its own wake.
            prop_assert_eq!(guard.wake_rested_ns(due_ns + 1, due_ns), due_ns);
        }
    }
}
