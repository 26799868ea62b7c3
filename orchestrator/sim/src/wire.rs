//! A link between two ends, in virtual time: when a packet comes out, if it does.

use link::{Epoch, Fate, PerWay, Profile, Timeline, Way};

/// A packet that comes out of a link as it was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Out {
    pub(crate) t_ns: u64,
    /// Whether a duplicate comes out with it.
    pub(crate) is_twice: bool,
}

/// The latest packet that came out.
#[derive(Debug, Clone, Copy, Default)]
struct Latest {
    out_ns: u64,
    read_ns: u64,
}

/// Both ways of a link, or no link between two ends on one machine.
#[derive(Debug)]
pub(crate) struct Wire {
    timeline: Option<Timeline>,
    has_rate: bool,
    epoch: Epoch,
    player_ns: u64,
    /// When the latest packet entered, each way: link time never runs backwards.
    entered_ns: PerWay<u64>,
    /// When the latest packet came out, each way, and when it was read.
    latest: PerWay<Latest>,
}

impl Wire {
    /// The link of `profile` under `seed`, which begins at `epoch`; its player adds `player_ns` each way.
    pub(crate) fn new(profile: &Profile, seed: u64, epoch: Epoch, player_ns: u32) -> Self {
        Self {
            timeline: (!profile.is_loopback()).then(|| Timeline::new(profile, seed, epoch)),
            has_rate: profile.has_rate(),
            epoch,
            player_ns: u64::from(player_ns),
            entered_ns: PerWay::default(),
            latest: PerWay::default(),
        }
    }

    /// Whether there is a rate limit, so that packets wait for others.
    #[inline]
    pub(crate) fn has_rate(&self) -> bool {
        self.has_rate
    }

    /// When a packet sent at `t_ns` enters the link. `None` without a rate limit or before link time
    /// 0: only then is the entry of every packet known.
    #[inline]
    pub(crate) fn enters_ns(&mut self, way: Way, t_ns: u64) -> Option<u64> {
        if !self.has_rate || self.epoch.link_time(t_ns).is_none() {
            return None;
        }
        let entered_ns = &mut self.entered_ns[way];
        *entered_ns = t_ns.max(*entered_ns);
        Some(*entered_ns)
    }

    /// How a packet of `bytes` (IP packet length) that enters at `t_ns` comes out; `None` if it is
    /// lost, or damaged so that its receiver discards it. Must be called in order of entry.
    #[inline]
    pub(crate) fn cross(&mut self, way: Way, t_ns: u64, bytes: u32) -> Option<Out> {
        match &mut self.timeline {
            None => Some(Out {
                t_ns,
                is_twice: false,
            }),
            Some(timeline) => play(timeline, self.player_ns, way, t_ns, bytes),
        }
    }

    /// When a packet that comes out at `out_ns` is read, if it alone would take `takes_ns` more: not
    /// before packets that came out earlier.
    #[inline]
    pub(crate) fn read_ns(&mut self, way: Way, out_ns: u64, takes_ns: u64) -> u64 {
        let latest = &mut self.latest[way];
        let read_ns = out_ns + takes_ns;
        if out_ns < latest.out_ns {
            // A link may reorder packets.
            return read_ns;
        }
        *latest = Latest {
            out_ns,
            read_ns: read_ns.max(latest.read_ns),
        };
        latest.read_ns
    }
}

/// How a packet comes out of a link whose player adds `player_ns`.
#[inline(never)]
fn play(timeline: &mut Timeline, player_ns: u64, way: Way, t_ns: u64, bytes: u32) -> Option<Out> {
    match timeline.transmit(way, t_ns, bytes) {
        Fate::Deliver { at, twist } if twist.flip.is_none() => Some(Out {
            t_ns: at + player_ns,
            is_twice: twist.twice,
        }),
        Fate::Deliver { .. } | Fate::Drop(_) => None,
    }
}
