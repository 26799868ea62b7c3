//! A link between two ends, in virtual time: when a packet that enters comes out, if it does.

use link::{Fate, Link, PerWay, Profile, Way};

/// A packet that has come out.
#[derive(Debug, Clone, Copy, Default)]
struct Latest {
    out_ns: u64,
    read_ns: u64,
}

/// Both ways of a link, or none between two ends on one machine.
#[derive(Debug)]
pub(crate) struct Wire {
    /// The empty link, which there is until link time 0, and the profile's.
    links: Option<[Link; 2]>,
    has_rate: bool,
    epoch_ns: u64,
    player_ns: u64,
    /// When the latest packet entered that goes up, and down: link time never runs backwards.
    entered_ns: PerWay<u64>,
    /// When the latest packet came out that went up, and down, and when it was read.
    latest: PerWay<Latest>,
}

impl Wire {
    /// The link of `profile` under `seed`, whose time 0 is `epoch_ns`; its player adds `player_ns`
    /// each way.
    pub(crate) fn new(profile: &Profile, seed: u64, epoch_ns: u64, player_ns: u32) -> Self {
        Self {
            // The empty link is constant: its seed says nothing.
            links: (!profile.is_loopback())
                .then(|| [Link::new(&Profile::empty(), 0), Link::new(profile, seed)]),
            has_rate: profile.has_rate(),
            epoch_ns,
            player_ns: u64::from(player_ns),
            entered_ns: PerWay::default(),
            latest: PerWay::default(),
        }
    }

    /// Whether there is a rate limit, and packets wait for others.
    pub(crate) fn has_rate(&self) -> bool {
        self.has_rate
    }

    /// When a packet enters that is sent at `t_ns`, if that is known of all of them: where there is
    /// a rate limit, from link time 0 on.
    pub(crate) fn enters_ns(&mut self, way: Way, t_ns: u64) -> Option<u64> {
        if !self.has_rate || t_ns < self.epoch_ns {
            return None;
        }
        let entered_ns = &mut self.entered_ns[way];
        *entered_ns = t_ns.max(*entered_ns);
        Some(*entered_ns)
    }

    /// When a packet of `bytes` (IP packet length) that enters at `t_ns` comes out; `None` if it
    /// is lost. To be asked in order of entry.
    pub(crate) fn cross(&mut self, way: Way, t_ns: u64, bytes: u32) -> Option<u64> {
        let Some([empty, link]) = &mut self.links else {
            return Some(t_ns);
        };
        let (link, origin_ns) = if t_ns < self.epoch_ns {
            (empty, 0)
        } else {
            (link, self.epoch_ns)
        };
        match link.path_mut(way).transmit(t_ns - origin_ns, bytes) {
            Fate::Deliver { at_ns } => Some(at_ns + origin_ns + self.player_ns),
            Fate::Drop(_) => None,
        }
    }

    /// When a packet is read that comes out at `out_ns` and by itself would take `takes_ns` more:
    /// not before one that came out before it.
    pub(crate) fn read_ns(&mut self, way: Way, out_ns: u64, takes_ns: u64) -> u64 {
        let latest = &mut self.latest[way];
        let read_ns = out_ns + takes_ns;
        if out_ns < latest.out_ns {
            // A link may let packets overtake.
            return read_ns;
        }
        *latest = Latest {
            out_ns,
            read_ns: read_ns.max(latest.read_ns),
        };
        latest.read_ns
    }
}
