//! When a link stalls, and how much of the time.
//!
//! A link is stalled where one of its ways is: a round trip meets both. What a stall does to a packet
//! is in `path`.

use crate::link::Link;
use crate::profile::{PathLaw, Profile};

/// A time in which one way of a link holds packets up, in link time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stall {
    /// Its begin, or link time 0 where it began before.
    pub start_ns: u64,
    /// When it ends, in ns of link time.
    pub end_ns: u64,
}

impl Profile {
    /// The stalls of either way under `seed` that reach into the time between two instants of link time,
    /// in order of their begin. Those of the two ways may overlap.
    #[must_use]
    pub fn stalls(&self, seed: u64, from_ns: u64, to_ns: u64) -> Vec<Stall> {
        let mut link = Link::new(self, seed);
        let mut stalls = Vec::new();
        for way in [&mut link.up, &mut link.down] {
            let mut t_ns = from_ns;
            while let Some(spell) = way.stall_after(t_ns).filter(|spell| spell.start_ns < to_ns) {
                stalls.push(Stall {
                    start_ns: spell.start_ns,
                    end_ns: spell.end_ns,
                });
                t_ns = spell.end_ns;
            }
        }
        stalls.sort_by_key(|stall| stall.start_ns);
        stalls
    }

    /// The share of the time between two instants of link time, 0 to 1, in which the link under `seed` is
    /// stalled; `None` where it never is, and between an instant and itself.
    #[must_use]
    pub fn stalled(&self, seed: u64, from_ns: u64, to_ns: u64) -> Option<f64> {
        self.stalled_by_law()?;
        let (mut known_ns, mut stalled_ns) = (from_ns, 0);
        for stall in self.stalls(seed, from_ns, to_ns) {
            let end_ns = stall.end_ns.min(to_ns);
            stalled_ns += end_ns.saturating_sub(stall.start_ns.max(known_ns));
            known_ns = known_ns.max(end_ns);
        }
        (to_ns > from_ns).then(|| stalled_ns as f64 / (to_ns - from_ns) as f64)
    }

    /// The same over a long time, by the law: the ways stall independently. `None` where neither does.
    #[must_use]
    pub fn stalled_by_law(&self) -> Option<f64> {
        let open = |law: &PathLaw| {
            let stall = law.stall.as_ref()?;
            Some(1.0 - (stall.length.mean_ns() / stall.every_ns as f64).min(1.0))
        };
        let ways = [open(&self.up), open(&self.down)];
        let open: f64 = ways.iter().flatten().product();
        ways.iter().any(Option::is_some).then_some(1.0 - open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const S: u64 = 1_000_000_000;

    fn couva() -> Profile {
        builtin("couva")
    }

    fn builtin(name: &str) -> Profile {
        Profile::parse(Profile::builtin(name).expect("built in"), name).expect("valid")
    }

    #[test]
    fn over_a_long_time_a_link_is_stalled_as_its_law_says() {
        // 7.4 % each way. In 20 000 s there are some 4600 stalls: the share is good to 2 %.
        let couva = couva();
        let law = couva.stalled_by_law().expect("it stalls");
        assert!((law - (1.0 - 0.926_f64.powi(2))).abs() < 1e-3, "{law}");
        let long = couva.stalled(1, 0, 20_000 * S).expect("it stalls");
        assert!((long / law - 1.0).abs() < 0.08, "{long} {law}");
        let never = builtin("buccoo");
        assert_eq!(
            (never.stalled_by_law(), never.stalled(1, 0, S)),
            (None, None)
        );
    }

    proptest! {
        #[test]
        fn within_a_stall_a_packet_waits_for_its_end(seed in 0u64..50, from_s in 0u64..20) {
            let couva = couva();
            for stall in couva.stalls(seed, from_s * S, (from_s + 10) * S) {
                prop_assert!(stall.end_ns > from_s * S && stall.start_ns < (from_s + 10) * S);
                let mut link = Link::new(&couva, seed);
                let waits = [&mut link.up, &mut link.down].map(|way| {
                    let state = way.state_at(stall.start_ns);
                    stall.start_ns + state.delay_ns >= stall.end_ns
                });
                prop_assert!(waits.contains(&true));
            }
        }

        #[test]
        fn the_parts_of_a_time_are_stalled_as_the_whole_is(seed in 0u64..50, at_s in 1u64..99) {
            let couva = couva();
            let share = |from_s: u64, to_s: u64| {
                let share = couva.stalled(seed, from_s * S, to_s * S).expect("it stalls");
                share * (to_s - from_s) as f64
            };
            prop_assert!((share(0, at_s) + share(at_s, 100) - share(0, 100)).abs() < 1e-6);
        }
    }
}
