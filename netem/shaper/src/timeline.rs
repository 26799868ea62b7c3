//! What the link does when: the empty link until the epoch, the profile's link from it on.
//!
//! The player and the prediction both ask here, so that they cannot differ in it.

use link::{Fate, Link, Path, Profile, State, Way};

/// A link as a run meets it, told in monotonic time.
#[derive(Debug)]
pub struct Timeline {
    empty: Link,
    link: Link,
    epoch_ns: u64,
}

impl Timeline {
    /// The link of `profile` and `seed`, whose time 0 is the monotonic instant `epoch_ns`.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64, epoch_ns: u64) -> Self {
        Self {
            // The empty link is constant: its seed says nothing.
            empty: Link::new(&Profile::empty(), 0),
            link: Link::new(profile, seed),
            epoch_ns,
        }
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
        let path = match way {
            Way::Up => &mut link.up,
            Way::Down => &mut link.down,
        };
        (path, t_link_ns, origin_ns)
    }
}
