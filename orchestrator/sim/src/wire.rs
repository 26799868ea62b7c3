//! A link between two ends, in virtual time: when a packet that enters comes out, if it does.

use link::{Fate, Link, Profile, Way};

/// Both ways of a link, or none between two ends on one machine.
#[derive(Debug)]
pub(crate) struct Wire {
    link: Option<Link>,
    epoch_ns: u64,
    player_ns: u64,
}

impl Wire {
    /// The link of `profile` under `seed`, whose time 0 is `epoch_ns`; its player adds `player_ns`
    /// each way.
    pub(crate) fn new(profile: &Profile, seed: u64, epoch_ns: u64, player_ns: u32) -> Self {
        Self {
            link: (!profile.is_loopback()).then(|| Link::new(profile, seed)),
            epoch_ns,
            player_ns: u64::from(player_ns),
        }
    }

    /// When a packet of `bytes` (IP packet length) that enters at `t_ns` comes out; `None` if it
    /// is lost. To be asked in order of entry.
    pub(crate) fn cross(&mut self, way: Way, t_ns: u64, bytes: u32) -> Option<u64> {
        let Some(link) = &mut self.link else {
            return Some(t_ns);
        };
        let path = match way {
            Way::Up => &mut link.up,
            Way::Down => &mut link.down,
        };
        match path.transmit(t_ns.saturating_sub(self.epoch_ns), bytes) {
            Fate::Deliver { at_ns } => Some(at_ns + self.epoch_ns + self.player_ns),
            Fate::Drop(_) => None,
        }
    }
}
