//! A run's link in time: the empty link until it opens, from then on the profile's link.
//!
//! The player and the prediction both use it, so that they cannot differ.

use crate::link::Link;
use crate::load::Load;
use crate::path::{Fate, Passage, Path, State};
use crate::piece::{Stay, Stretch};
use crate::profile::Profile;
use crate::time::{Epoch, LinkTime};
use crate::way::{PerWay, Way};

/// A link as a run meets it, in monotonic time.
#[derive(Debug, Clone)]
pub struct Timeline {
    empty: Link,
    link: Link,
    epoch: Epoch,
    /// The link time from which on the link is in force.
    opens: LinkTime,
    /// The link time after which nothing changes any more.
    closes: LinkTime,
    /// The packets that entered each way, if they are known and matter.
    loads: PerWay<Option<Load>>,
}

impl Timeline {
    /// The link of `profile` and `seed`, which begins at `epoch` and is in force from then on.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64, epoch: Epoch) -> Self {
        // Between two ends on one machine there is never a link.
        let before = if profile.is_loopback() {
            profile.clone()
        } else {
            Profile::empty()
        };
        Self {
            // The empty link is constant, so its seed has no effect.
            empty: Link::new(&before, 0),
            link: Link::new(profile, seed),
            epoch,
            opens: LinkTime::ZERO,
            closes: LinkTime::from_ns(u64::MAX),
            loads: PerWay::default(),
        }
    }

    /// The same link, in force only from link time `opens` on: what it does then, it does as if it had been
    /// there from its beginning, but no packet has met it.
    #[must_use]
    pub fn opening(self, opens: LinkTime) -> Self {
        Self { opens, ..self }
    }

    /// The same link, which stays as it is at link time `closes` for whoever asks for a later instant. What a link
    /// does is found step by step from its beginning: a stamp that is not of the run would take years of it.
    #[must_use]
    pub fn closing(self, closes: LinkTime) -> Self {
        Self { closes, ..self }
    }

    /// The same timeline with the packets that entered one way: each packet's monotonic instant and
    /// IP length, in order. Without a rate limit on that way they have no effect.
    #[must_use]
    pub fn with_load(mut self, way: Way, packets: impl IntoIterator<Item = (u64, u32)>) -> Self {
        // The link's queue is empty when it opens.
        let packets = packets
            .into_iter()
            .filter_map(|(t_ns, bytes)| Some((self.link_time(t_ns)?, bytes)));
        self.loads[way] = self.link.path(way).load(packets);
        self
    }

    /// The IP length of the first packet of `at_least` bytes that entered a way within `within_ns`
    /// from `t_ns` on, if the packets are known.
    #[must_use]
    pub fn bytes_entered(&self, way: Way, t_ns: u64, within_ns: u64, at_least: u32) -> Option<u32> {
        let load = self.loads[way].as_ref()?;
        load.bytes(self.link_time(t_ns)?, within_ns, at_least)
    }

    /// What a packet of `bytes` (IP length) that enters at `t_ns` meets.
    pub fn passage(&mut self, way: Way, t_ns: u64, bytes: u32) -> Passage {
        let load = self.loads[way].take();
        let (path, t, _) = self.path(way, t_ns);
        let passage = path.passage(t, bytes, load.as_ref());
        self.loads[way] = load;
        passage
    }

    /// What a packet of `bytes` that enters at `t_ns` meets, and so do those that enter after it, up to the end of the
    /// piece: what [`Timeline::passage`] says of each of its instants.
    pub fn piece(&mut self, way: Way, t_ns: u64, bytes: u32) -> Stretch {
        let load = self.loads[way].take();
        let (path, t, origin) = self.path(way, t_ns);
        let piece = path.piece(t, bytes, load.as_ref());
        self.loads[way] = load;
        Stretch {
            delays: self.bounded(piece.delays, t, origin, t_ns),
            ..piece
        }
    }

    /// The delays of [`Timeline::piece`], up to the end of a piece that no loss ends.
    pub fn delays(&mut self, way: Way, t_ns: u64, bytes: u32) -> Stay {
        let load = self.loads[way].take();
        let (path, t, origin) = self.path(way, t_ns);
        let delays = path.delays(t, bytes, load.as_ref());
        self.loads[way] = load;
        self.bounded(delays, t, origin, t_ns)
    }

    /// Delays of a path from its own time `t` on, in monotonic time from `t_ns` on, until the link opens or closes.
    #[inline]
    fn bounded(&self, delays: Stay, t: LinkTime, origin: Epoch, t_ns: u64) -> Stay {
        let seen = delays.seen_from(origin);
        match self.link_time(t_ns) {
            None => Stay {
                end_ns: seen.end_ns.min(self.epoch.t_ns(self.opens)),
                ..seen
            },
            Some(asked) if asked > self.closes => Stay::always(delays.delay_ns(t.ns())),
            // At its last instant it is open.
            Some(_) => Stay {
                end_ns: seen.end_ns.min(self.epoch.t_ns(self.closes.after(1))),
                ..seen
            },
        }
    }

    /// Decides the fate of a packet of `bytes` (IP length) that enters at `t_ns`; a departure is in
    /// monotonic time too. Must be called in order of entry on each way.
    #[inline]
    pub fn transmit(&mut self, way: Way, t_ns: u64, bytes: u32) -> Fate<u64> {
        let (path, t, origin) = self.path(way, t_ns);
        match path.transmit(t, bytes) {
            Fate::Deliver { at, twist } => Fate::Deliver {
                at: origin.t_ns(at),
                twist,
            },
            Fate::Drop(cause) => Fate::Drop(cause),
        }
    }

    /// The state at an instant, regardless of traffic.
    pub fn state_at(&mut self, way: Way, t_ns: u64) -> State {
        let (path, t, _) = self.path(way, t_ns);
        path.state_at(t)
    }

    /// The last instant up to `t_ns` at which faults of either way may have broken connections of TCP.
    pub fn broken_ns(&mut self, t_ns: u64) -> Option<u64> {
        let broken = |way| {
            let (path, t, origin) = self.path(way, t_ns);
            path.broken(t).map(|t| origin.t_ns(t))
        };
        Way::BOTH.into_iter().filter_map(broken).max()
    }

    /// Whether a fault that loses or damages packets is in force on a way.
    pub fn loses_by_fault(&mut self, way: Way, t_ns: u64) -> bool {
        let (path, t, _) = self.path(way, t_ns);
        path.loses_by_fault(t)
    }

    /// Whether a packet may be lost or damaged on a way at all. Before it opens, a link loses none.
    #[must_use]
    pub fn may_lose(&self, way: Way) -> bool {
        self.link.path(way).may_lose()
    }

    /// Whether a packet may leave a way before one that entered earlier, by the profile's order. A fault may let it.
    #[must_use]
    pub fn may_overtake(&self, way: Way) -> bool {
        self.link.path(way).may_overtake()
    }

    /// The path in force at `t_ns`, that instant in the path's own time, and the origin of that time;
    /// for the empty link, the machine's.
    #[inline]
    fn path(&mut self, way: Way, t_ns: u64) -> (&mut Path, LinkTime, Epoch) {
        let (link, t, origin) = match self.link_time(t_ns) {
            Some(t) => (&mut self.link, t.min(self.closes), self.epoch),
            None => (&mut self.empty, LinkTime::from_ns(t_ns), Epoch::default()),
        };
        (link.path_mut(way), t, origin)
    }

    /// The link time of a monotonic instant; `None` before the link opens.
    #[inline]
    fn link_time(&self, t_ns: u64) -> Option<LinkTime> {
        self.epoch
            .link_time(t_ns)
            .filter(|time| *time >= self.opens)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EPOCH: Epoch = Epoch::at_ns(5_000_000_000);
    const OPENS: LinkTime = LinkTime::from_ns(1_180_000_000);

    fn couva() -> Profile {
        Profile::parse(Profile::builtin("couva").unwrap(), "couva").unwrap()
    }

    #[test]
    fn a_link_that_has_closed_stays_as_it_was_however_late_one_asks() {
        let closes = LinkTime::from_ns(20_000_000_000);
        let mut closed = Timeline::new(&couva(), 3, EPOCH).closing(closes);
        let mut open = Timeline::new(&couva(), 3, EPOCH);
        for t_ns in [6_000_000_000, 24_999_999_999, EPOCH.t_ns(closes)] {
            for way in Way::BOTH {
                assert_eq!(closed.state_at(way, t_ns), open.state_at(way, t_ns));
            }
        }
        for t_ns in [25_000_000_001, u64::MAX / 2, u64::MAX] {
            for way in Way::BOTH {
                let last = open.state_at(way, EPOCH.t_ns(closes));
                assert_eq!(closed.state_at(way, t_ns), last);
                assert_eq!(closed.passage(way, t_ns, 100).delay_ns, last.delay_ns);
            }
        }
    }

    #[test]
    fn a_link_that_opens_late_is_empty_before_and_then_as_if_it_had_always_been_there() {
        let always = || Timeline::new(&couva(), 3, EPOCH);
        let mut empty = Timeline::new(&Profile::empty(), 0, EPOCH);
        let (mut asked, mut late) = (always(), always().opening(OPENS));
        for t_ns in (EPOCH.t_ns(LinkTime::ZERO)..EPOCH.t_ns(LinkTime::from_ns(4_000_000_000)))
            .step_by(700_001)
        {
            for way in Way::BOTH {
                let due = if t_ns < EPOCH.t_ns(OPENS) {
                    empty.state_at(way, t_ns)
                } else {
                    asked.state_at(way, t_ns)
                };
                assert_eq!(late.state_at(way, t_ns), due, "{way:?} {t_ns}");
            }
        }
    }

    /// Both directions alike, with these lines.
    fn profile(lines: &str) -> Profile {
        let source = format!("name = 'p'\nabout = ''\n{lines}\n");
        Profile::parse(&source, "p").unwrap_or_else(|findings| panic!("{source}{findings:?}"))
    }

    /// Links with and without stalls, losses of each kind, a rate, and faults.
    fn links() -> impl Strategy<Value = Profile> {
        let level = "[both.delay]\nbase = '2ms'\nhold = '20ms'\nmax = '80ms'\nspread.exponential.mean = '9ms'";
        let stall = "[both.stall]\nevery = '900ms'\nlength.exponential.mean = '60ms'\nmax = '1s'";
        let burst = "[both.loss.gilbert-elliott]\ngood = '200ms'\nbad = '20ms'\nin-bad = '70%'";
        let slow = "[both]\nrate = '2mbit'\nlimit = 50";
        let outage = "[[fault]]\nat = '200ms'\nfor = '50ms'\nevery = '300ms'\ndown = true";
        let later = "[[fault]]\nat = '200ms'\nfor = '50ms'\nevery = '300ms'\ndelay = '30ms'";
        prop_oneof![
            Just(couva()),
            Just(Profile::empty()),
            Just(profile(level)),
            Just(profile(&format!(
                "[both]\norder = 'free'\n{level}\n{stall}"
            ))),
            Just(profile(&format!("{level}\n{stall}\n{burst}"))),
            Just(profile(&format!("{slow}\n{level}\n{burst}"))),
            Just(profile(&format!("{level}\n{outage}"))),
            Just(profile(&format!("{level}\n{stall}\n{later}"))),
        ]
    }

    proptest! {
        /// Before it opens, while it is open and after it has closed.
        #[test]
        fn a_piece_says_of_each_of_its_instants_what_the_link_does_then(
            profile in links(), seed: u64, from_ns in 5_900_000_000_u64..6_300_000_000,
            steps in prop::collection::vec(1_u64..40_000_000, 1..40), loads: bool,
        ) {
            let closes = LinkTime::from_ns(1_900_000_000);
            let mut link = Timeline::new(&profile, seed, EPOCH).opening(OPENS).closing(closes);
            if loads {
                let packets = (0..2_000).map(|k| (6_000_000_000 + k * 700_000, 900));
                link = link.with_load(Way::Up, packets);
            }
            let (mut asked, mut delays) = (link.clone(), link.clone());
            let mut t_ns = from_ns;
            for step_ns in steps {
                t_ns += step_ns;
                let piece = link.piece(Way::Up, t_ns, 100);
                let alone = delays.delays(Way::Up, t_ns, 100);
                prop_assert!(t_ns < piece.delays.end_ns && piece.delays.end_ns <= alone.end_ns);
                // A link looks back 10 s at most.
                let far_ns = t_ns + 9_000_000_000;
                let last_ns = piece.delays.end_ns.min(far_ns) - 1;
                for t_ns in [t_ns, t_ns + (last_ns - t_ns) / 3, last_ns] {
                    let passage = asked.passage(Way::Up, t_ns, 100);
                    prop_assert_eq!(piece.delays.delay_ns(t_ns), passage.delay_ns);
                    prop_assert_eq!((piece.lost, piece.queued), (passage.lost, passage.queued));
                }
                for t_ns in [t_ns, alone.end_ns.min(far_ns) - 1] {
                    let passage = asked.passage(Way::Up, t_ns, 100);
                    prop_assert_eq!(alone.delay_ns(t_ns), passage.delay_ns);
                }
                asked = link.clone();
            }
        }

        #[test]
        fn who_looks_ahead_and_back_sees_what_who_goes_on_sees(
            profile in links(), seed: u64,
            steps in prop::collection::vec((1_u64..9_000_000, 0_u64..60_000_000), 1..80),
        ) {
            let mut on = Timeline::new(&profile, seed, EPOCH).opening(OPENS);
            let mut ahead = on.clone();
            let mut t_ns = 6_100_000_000;
            for (step_ns, ahead_ns) in steps {
                t_ns += step_ns;
                ahead.passage(Way::Up, t_ns + ahead_ns, 100);
                prop_assert_eq!(ahead.passage(Way::Up, t_ns, 100), on.passage(Way::Up, t_ns, 100));
            }
        }

        #[test]
        fn a_way_that_may_not_lose_loses_nothing(
            profile in links(), seed: u64, times in prop::collection::vec(0_u64..9_000_000_000, 1..200),
        ) {
            let mut link = Timeline::new(&profile, seed, EPOCH);
            for t_ns in times {
                for way in Way::BOTH {
                    let is_lost = link.passage(way, EPOCH.t_ns(LinkTime::from_ns(t_ns)), 100).lost;
                    prop_assert!(link.may_lose(way) || !is_lost);
                }
            }
        }
    }

    #[test]
    fn a_link_may_lose_that_has_loss_a_rate_or_a_fault_but_not_by_its_delay() {
        let may_lose = |lines: &str| {
            let profile = profile(&format!("[both.delay]\nbase = '2ms'\n{lines}"));
            Timeline::new(&profile, 1, EPOCH).may_lose(Way::Up)
        };
        assert!(!may_lose(""));
        assert!(may_lose("[both.loss.random]\nshare = '1%'"));
        assert!(may_lose("[both]\nrate = '2mbit'"));
        assert!(may_lose("[[fault]]\nat = '2s'\nfor = '50ms'\ndown = true"));
    }
}
