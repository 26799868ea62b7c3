//! How long before a departure the player wakes, learnt from how late its earlier wakes were. Pure. `pace` has
//! the same lines for the ends.

use certificate::Scheduling;

/// The time before a departure at which a real-time player wakes, to poll the clock until then.
///
/// It follows the upper quantile of the lateness that one wake in fifty exceeds: so a packet is hardly
/// ever late, and the player spins hardly longer than a wake varies. It moves by a small step a wake, whatever
/// the lateness was, so a disturbance changes it little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Guard {
    ns: u64,
    most_ns: u64,
}

impl Guard {
    /// Near what waking a halted core takes on a virtual machine.
    const FIRST_NS: u64 = 50_000;

    /// The most, which at 1 kHz is a seventh of a core. A wake that was later teaches nothing: the thread, or
    /// the whole machine, was held up.
    const MOST_NS: u64 = 150_000;

    /// One step up for fifty steps down: the quantile of 98 %.
    const UP_NS: u64 = 2_000;
    const DOWN_NS: u64 = 40;

    /// The guard of a player with this scheduling.
    pub(crate) fn of(scheduling: Scheduling) -> Self {
        match scheduling {
            Scheduling::Fifo => Self::new(),
            Scheduling::Other => Self::none(),
        }
    }

    /// A guard that learns.
    const fn new() -> Self {
        Self {
            ns: Self::FIRST_NS,
            most_ns: Self::MOST_NS,
        }
    }

    /// For a player that only sleeps.
    const fn none() -> Self {
        Self { ns: 0, most_ns: 0 }
    }

    /// When to wake for a departure.
    pub(crate) fn wake_ns(self, due_ns: u64) -> u64 {
        due_ns.saturating_sub(self.ns)
    }

    /// A wake was so late.
    pub(crate) fn learn(&mut self, late_ns: u64) {
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
    }
}
