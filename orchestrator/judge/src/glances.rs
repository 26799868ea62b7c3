//! The instants at which the link is looked at for a message, taken together where a piece of the link has several.
//!
//! Loss is decided by the millisecond, and a part of a window that is lost is told as a part of its looks, so the looks
//! stay where they are however long the link's pieces are. What is seen there is the caller's.

use std::ops::RangeInclusive;

/// The link is looked at least this often, ns: no millisecond may be stepped over.
pub(crate) const LOOK_NS: u64 = 250_000;

/// The same for a wide window, ns.
const WIDE_LOOK_NS: u64 = 500_000;

/// The looks of a window that are left: first those of the time before it, then its own.
#[derive(Debug)]
pub(crate) struct Glances {
    next_ns: Option<u64>,
    /// When the window begins.
    from_ns: u64,
    /// When the message was stamped, in the window.
    t_ns: u64,
    /// The end of the window, at which the last look is: a packet that enters then leaves last.
    last_ns: u64,
    step_ns: u64,
}

/// Looks one after the other, all before the window or all in it, and none before the message's stamp with one after it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Together {
    pub(crate) first_ns: u64,
    pub(crate) last_ns: u64,
    pub(crate) count: u32,
    pub(crate) is_before: bool,
}

impl Glances {
    /// The looks from `begins_ns` on: before `window`, for a message that was stamped at `t_ns` in it, and in it.
    pub(crate) fn new(begins_ns: u64, window: &RangeInclusive<u64>, t_ns: u64) -> Glances {
        let (from_ns, last_ns) = (*window.start(), *window.end());
        Glances {
            next_ns: Some(begins_ns),
            from_ns,
            t_ns,
            last_ns,
            step_ns: ((last_ns - t_ns) / 16).clamp(LOOK_NS, WIDE_LOOK_NS),
        }
    }

    /// When the next look is, if one is left.
    #[inline]
    pub(crate) fn next_ns(&self) -> Option<u64> {
        self.next_ns
    }

    /// Takes the next look, at `first_ns`, with those before `end_ns` that are like it.
    #[inline]
    pub(crate) fn take(&mut self, first_ns: u64, end_ns: u64) -> Together {
        let is_before = first_ns < self.from_ns;
        let (through_ns, goes_on_ns) = match is_before {
            true => (self.from_ns - 1, self.from_ns),
            false if first_ns <= self.t_ns => (self.t_ns, self.last_ns),
            false => (self.last_ns, self.last_ns),
        };
        let room_ns = through_ns
            .min(end_ns.saturating_sub(1))
            .saturating_sub(first_ns);
        // Mostly there is no more than one, and a division takes longer than all the rest.
        let more = match room_ns < self.step_ns {
            true => 0,
            false => room_ns / self.step_ns,
        };
        let last_ns = first_ns + more * self.step_ns;
        let after_ns = last_ns.saturating_add(self.step_ns).min(goes_on_ns);
        self.next_ns = (last_ns < self.last_ns).then_some(after_ns);
        Together {
            first_ns,
            last_ns,
            count: (more + 1) as u32,
            is_before,
        }
    }
}

#[cfg(test)]
mod tests {
    use link::{Epoch, LinkTime, Profile, Timeline, Way};
    use plan::Client;
    use proptest::prelude::*;

    use super::*;
    use crate::busy::Busy;
    use crate::connecting::Connecting;
    use crate::hit::Hits;
    use crate::milliseconds::ns;
    use crate::still::Still;
    use crate::terms::{MESSAGE_BYTES, Terms};

    const MS: u64 = 1_000_000;
    const EPOCH_NS: u64 = 1_000 * MS;

    fn terms(client: Client, before_ns: u64, timeline: Timeline) -> Terms {
        Terms {
            timeline,
            run_ns: 0..u64::MAX,
            before_ns,
            fall_ns: 70_000,
            baseline_ms: [0.0; 2],
            allowance: client.spec().allowance,
            connecting: Connecting::Pool { accepted: None },
            has_rate: false,
            timeout_ms: 5_000.0,
            busy: Busy::default(),
            h_ms: 1.0,
            still: Still::default(),
            hits: Hits::default(),
        }
    }

    /// Links without anything, with stalls and losses, out of order, with a rate, and with faults.
    fn sources() -> impl Strategy<Value = &'static str> {
        const SLOW: &str = "name = 'slow'\nabout = ''\n[both]\nrate = '2mbit'\n[both.delay]\nbase = '3ms'\n\
                            [both.loss.random]\nshare = '20%'\n";
        const CUT: &str = "name = 'cut'\nabout = ''\n[both.delay]\nbase = '3ms'\n\
                           [[fault]]\nat = '2s'\nfor = '50ms'\nevery = '200ms'\ndown = true\n";
        let builtin = ["arima", "couva", "diego-vpn", "diego-vpn-free"];
        let builtin = builtin.iter().filter_map(|name| Profile::builtin(name));
        prop::sample::select(builtin.chain([SLOW, CUT]).collect::<Vec<_>>())
    }

    /// The window as it is defined: the link asked at each look by itself. Its earliest, latest and slowest, ns, and
    /// its lossy part.
    fn one_by_one(terms: &Terms, t_ns: u64, within_ns: u64) -> ([u64; 3], f64) {
        let mut link = terms.timeline.clone();
        let (mut earliest_ns, mut latest_ns, mut slowest_ns) = (u64::MAX, 0, 0);
        let (mut count, mut lossy) = (0_u32, 0_u32);
        let step_ns = (within_ns / 16).clamp(LOOK_NS, WIDE_LOOK_NS);
        let from_ns = t_ns.saturating_sub(terms.before_ns);
        let mut look_ns = from_ns.saturating_sub(ns(terms.allowance.clock_ms));
        let last_ns = t_ns + within_ns;
        loop {
            let passage = link.passage(Way::Up, look_ns, MESSAGE_BYTES);
            let leaves_ns = look_ns.max(t_ns) + passage.delay_ns;
            earliest_ns = earliest_ns.min(leaves_ns);
            if look_ns < from_ns {
                look_ns = (look_ns + step_ns).min(from_ns);
                continue;
            }
            latest_ns = latest_ns.max(if passage.queued { u64::MAX } else { leaves_ns });
            slowest_ns = slowest_ns.max(passage.delay_ns);
            count += 1;
            lossy += u32::from(passage.lost);
            if look_ns == last_ns {
                break;
            }
            look_ns = (look_ns + step_ns).min(last_ns);
        }
        let fall_ns = terms.fall_ns;
        let bounds_ns = [
            earliest_ns.saturating_sub(fall_ns),
            latest_ns.saturating_add(fall_ns),
            slowest_ns + fall_ns,
        ];
        (bounds_ns, f64::from(lossy) / f64::from(count))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// So it holds each instant at which a look finds a loss or a change, and tells the same part of them as lost.
        #[test]
        fn a_window_by_pieces_is_the_window_look_by_look(
            source in sources(),
            client in prop::sample::select(Client::ALL.to_vec()),
            seed: u64, before_ns in prop::sample::select(vec![0, 30_000, 2 * MS]),
            times in prop::collection::vec((0_u64..20_000 * MS, 0_u64..400 * MS), 1..12),
        ) {
            let (profile, _) = Profile::read(source, "test", &|_: &str| Err(String::new()));
            let link = Timeline::new(&profile.expect("valid"), seed, Epoch::at_ns(EPOCH_NS));
            let link = link.opening(LinkTime::from_ns(MS / 3)).closing(LinkTime::from_ns(15_000 * MS));
            let terms = terms(client, before_ns, link.clone());
            for (t_ns, within_ns) in times {
                let (bounds_ns, lossy) = one_by_one(&terms, t_ns, within_ns);
                let window = terms.window(&mut link.clone(), Way::Up, t_ns, within_ns, MESSAGE_BYTES);
                prop_assert_eq!([window.latest_ns, window.slowest_ns], [bounds_ns[1], bounds_ns[2]]);
                // Where packets overtake each other one may be out first that entered between two looks.
                prop_assert!(window.earliest_ns <= bounds_ns[0]);
                prop_assert!(window.earliest_ns == bounds_ns[0] || source.contains("order = \"free\""));
                prop_assert_eq!(window.lossy, lossy);
                let earliest_ns = terms.earliest_ns(&mut link.clone(), Way::Up, t_ns, within_ns);
                prop_assert_eq!(earliest_ns, window.earliest_ns);
            }
        }

        /// Looked at each 20 microseconds, none is out before the earliest, and one nearly as early.
        #[test]
        fn the_earliest_of_a_window_is_that_of_all_its_instants(
            source in sources(), seed: u64, t_ns in 0_u64..5_000 * MS, within_ns in 0_u64..30 * MS,
        ) {
            const STEP_NS: u64 = 20_000;
            let (profile, _) = Profile::read(source, "test", &|_: &str| Err(String::new()));
            let profile = profile.expect("valid");
            let link = Timeline::new(&profile, seed, Epoch::at_ns(0));
            let terms = terms(Client::Native, 0, link.clone());
            let from_ns = t_ns.saturating_sub(ns(terms.allowance.clock_ms));
            let mut each = link.clone();
            let out_ns = (from_ns..=t_ns + within_ns).step_by(STEP_NS as usize).map(|at_ns| {
                at_ns.max(t_ns) + each.passage(Way::Up, at_ns, MESSAGE_BYTES).delay_ns
            });
            let first_ns = out_ns.min().expect("an instant").saturating_sub(terms.fall_ns);
            let earliest_ns = terms.earliest_ns(&mut link.clone(), Way::Up, t_ns, within_ns);
            // A queue is looked at where the looks are, as before.
            let slack_ns = if profile.has_rate() { super::WIDE_LOOK_NS } else { STEP_NS };
            prop_assert!(earliest_ns <= first_ns + slack_ns, "{} {}", earliest_ns, first_ns);
            prop_assert!(earliest_ns + slack_ns >= first_ns, "{} {}", earliest_ns, first_ns);
        }
    }
}
