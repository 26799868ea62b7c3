//! What the link does when: the empty link until the epoch, the profile's link from it on.
//!
//! The player and the prediction both ask here, so that they cannot differ in it.

use crate::{Fate, Link, Load, Passage, Path, PerWay, Profile, State, Way};

/// A link as a run meets it, in monotonic time.
#[derive(Debug, Clone)]
pub struct Timeline {
    empty: Link,
    link: Link,
    epoch_ns: u64,
    /// What entered each way, where that is known and matters.
    loads: PerWay<Option<Load>>,
}

impl Timeline {
    /// The link of `profile` and `seed`, whose time 0 is the monotonic instant `epoch_ns`.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64, epoch_ns: u64) -> Self {
        // Between two ends on one machine there is no link at any time.
        let before = if profile.is_loopback() {
            profile.clone()
        } else {
            Profile::empty()
        };
        Self {
            // The empty link is constant: its seed says nothing.
            empty: Link::new(&before, 0),
            link: Link::new(profile, seed),
            epoch_ns,
            loads: PerWay::default(),
        }
    }

    /// The same, where it is known what entered one way: each packet's monotonic instant and IP
    /// length, in order. Of a way without a rate limit that says nothing.
    #[must_use]
    pub fn with_load(mut self, way: Way, packets: impl IntoIterator<Item = (u64, u32)>) -> Self {
        let epoch_ns = self.epoch_ns;
        // The link's queue is empty when its time begins.
        let packets = packets
            .into_iter()
            .filter_map(|(t_ns, bytes)| Some((t_ns.checked_sub(epoch_ns)?, bytes)));
        self.loads[way] = self.link.path(way).load(packets);
        self
    }

    /// The IP length of the first packet of `at_least` bytes that entered a way within `within_ns` from
    /// `t_ns` on, where it is known what entered.
    #[must_use]
    pub fn bytes_entered(&self, way: Way, t_ns: u64, within_ns: u64, at_least: u32) -> Option<u32> {
        let load = self.loads[way].as_ref()?;
        load.bytes(t_ns.checked_sub(self.epoch_ns)?, within_ns, at_least)
    }

    /// What a packet of `bytes` (of IP) meets that enters at `t_ns`.
    pub fn passage(&mut self, way: Way, t_ns: u64, bytes: u32) -> Passage {
        let load = self.loads[way].take();
        let (path, t_link_ns, _) = self.path(way, t_ns);
        let passage = path.passage(t_link_ns, bytes, load.as_ref());
        self.loads[way] = load;
        passage
    }

    /// Decides on a packet of `bytes` (of IP) that enters at `t_ns`, and tells a departure in
    /// monotonic time too. Calls per way go in order of entry.
    pub fn transmit(&mut self, way: Way, t_ns: u64, bytes: u32) -> Fate {
        let (path, t_link_ns, origin_ns) = self.path(way, t_ns);
        match path.transmit(t_link_ns, bytes) {
            Fate::Deliver { at_ns } => Fate::Deliver {
                at_ns: at_ns.saturating_add(origin_ns),
            },
            dropped @ Fate::Drop(_) => dropped,
        }
    }

    /// The state at an instant, whatever the traffic.
    pub fn state_at(&mut self, way: Way, t_ns: u64) -> State {
        let (path, t_link_ns, _) = self.path(way, t_ns);
        path.state_at(t_link_ns)
    }

    /// The path that plays at `t_ns`, that instant in the path's own time, and the monotonic
    /// instant at which that time is 0.
    fn path(&mut self, way: Way, t_ns: u64) -> (&mut Path, u64, u64) {
        let (link, t_link_ns, origin_ns) = match t_ns.checked_sub(self.epoch_ns) {
            Some(t_link_ns) => (&mut self.link, t_link_ns, self.epoch_ns),
            None => (&mut self.empty, t_ns, 0),
        };
        (link.path_mut(way), t_link_ns, origin_ns)
    }
}
