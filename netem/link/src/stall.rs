//! When a link stalls, and for what share of the time.
//!
//! A link is stalled if either way is, since a round trip uses both. `path` has what a stall does to
//! a packet.

use crate::link::Link;
use crate::profile::{PathLaw, Profile};
use crate::time::LinkTime;

/// A time during which one way of a link holds packets back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stall {
    /// When it begins, or link time 0 if it began before.
    pub start: LinkTime,
    /// When it ends.
    pub end: LinkTime,
}

impl Profile {
    /// The stalls of either way under `seed` that overlap the time between two instants of link time,
    /// in order of their beginning. Stalls of the two ways may overlap each other.
    #[must_use]
    pub fn stalls(&self, seed: u64, from: LinkTime, to: LinkTime) -> Vec<Stall> {
        let mut link = Link::new(self, seed);
        let mut stalls = Vec::new();
        for way in [&mut link.up, &mut link.down] {
            let mut t = from;
            while let Some(spell) = way.stall_after(t) {
                let [start, end] = [spell.start_ns, spell.end_ns].map(LinkTime::from_ns);
                if start >= to {
                    break;
                }
                stalls.push(Stall { start, end });
                t = end;
            }
        }
        stalls.sort_by_key(|stall| stall.start);
        stalls
    }

    /// The share of the time between two instants of link time, 0 to 1, during which the link under
    /// `seed` is stalled; `None` if it never stalls, or if the time is empty.
    #[must_use]
    pub fn stalled(&self, seed: u64, from: LinkTime, to: LinkTime) -> Option<f64> {
        self.stalled_by_law()?;
        let (mut known, mut stalled_ns) = (from, 0);
        for stall in self.stalls(seed, from, to) {
            let end = stall.end.min(to);
            stalled_ns += end.since(stall.start.max(known));
            known = known.max(end);
        }
        (to > from).then(|| stalled_ns as f64 / to.since(from) as f64)
    }

    /// The same over a long time, by the law, since the ways stall independently. `None` if neither does.
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

    fn at_s(s: u64) -> LinkTime {
        LinkTime::from_ns(s * 1_000_000_000)
    }

    fn couva() -> Profile {
        builtin("couva")
    }

    fn builtin(name: &str) -> Profile {
        Profile::parse(Profile::builtin(name).expect("built in"), name).expect("valid")
    }

    #[test]
    fn over_a_long_time_a_link_is_stalled_as_its_law_says() {
        // 7.4 % each way. In 20 000 s there are some 4600 stalls, so the share is accurate to 2 %.
        let couva = couva();
        let law = couva.stalled_by_law().expect("it stalls");
        assert!((law - (1.0 - 0.926_f64.powi(2))).abs() < 1e-3, "{law}");
        let long = couva
            .stalled(1, LinkTime::ZERO, at_s(20_000))
            .expect("it stalls");
        assert!((long / law - 1.0).abs() < 0.08, "{long} {law}");
        let never = builtin("buccoo");
        assert_eq!(
            (
                never.stalled_by_law(),
                never.stalled(1, LinkTime::ZERO, at_s(1))
            ),
            (None, None)
        );
    }

    proptest! {
        #[test]
        fn within_a_stall_a_packet_waits_for_its_end(seed in 0u64..50, from_s in 0u64..20) {
            let couva = couva();
            for stall in couva.stalls(seed, at_s(from_s), at_s(from_s + 10)) {
                prop_assert!(stall.end > at_s(from_s) && stall.start < at_s(from_s + 10));
                let mut link = Link::new(&couva, seed);
                let waits = [&mut link.up, &mut link.down].map(|way| {
                    let state = way.state_at(stall.start);
                    stall.start.after(state.delay_ns) >= stall.end
                });
                prop_assert!(waits.contains(&true));
            }
        }

        #[test]
        fn the_parts_of_a_time_are_stalled_as_the_whole_is(seed in 0u64..50, middle_s in 1u64..99) {
            let couva = couva();
            let share = |from_s: u64, to_s: u64| {
                let share = couva.stalled(seed, at_s(from_s), at_s(to_s)).expect("it stalls");
                share * (to_s - from_s) as f64
            };
            prop_assert!((share(0, middle_s) + share(middle_s, 100) - share(0, 100)).abs() < 1e-6);
        }
    }
}
