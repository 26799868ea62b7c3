//! A run's link in time: the empty link until it opens, from then on the profile's link.
//!
//! The player and the prediction both use it, so that they cannot differ.

use crate::{Epoch, Fate, Link, LinkTime, Load, Passage, Path, PerWay, Profile, State, Way};

/// A link as a run meets it, in monotonic time.
#[derive(Debug, Clone)]
pub struct Timeline {
    empty: Link,
    link: Link,
    epoch: Epoch,
    /// The link time from which on the link is in force.
    opens: LinkTime,
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
            loads: PerWay::default(),
        }
    }

    /// The same link, in force only from link time `opens` on: what it does then, it does as if it had been
    /// there from its beginning, but no packet has met it.
    #[must_use]
    pub fn opening(self, opens: LinkTime) -> Self {
        Self { opens, ..self }
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

    /// The path in force at `t_ns`, that instant in the path's own time, and the origin of that time;
    /// for the empty link, the machine's.
    #[inline]
    fn path(&mut self, way: Way, t_ns: u64) -> (&mut Path, LinkTime, Epoch) {
        let (link, t, origin) = match self.link_time(t_ns) {
            Some(t) => (&mut self.link, t, self.epoch),
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

    const EPOCH: Epoch = Epoch::at_ns(5_000_000_000);
    const OPENS: LinkTime = LinkTime::from_ns(1_180_000_000);

    fn couva() -> Profile {
        Profile::parse(Profile::builtin("couva").unwrap(), "couva").unwrap()
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
}
