//! A piece of time in which a link does the same to all packets, so that a question about a span of time need not be
//! asked instant by instant.
//!
//! Which pieces there are follows from what a path is made of: the path has them.

use crate::time::{Epoch, LinkTime};

/// How long packets take that enter in a piece of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stay {
    /// What each takes, ns, unless it is held.
    pub level_ns: u64,
    /// None leaves before this instant.
    pub held_until_ns: u64,
    /// The end of the piece, which is not in it any more.
    pub end_ns: u64,
}

/// What packets meet that enter in a piece of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// Their delays, and the end of the piece.
    pub delays: Stay,
    /// Whether they are lost or damaged, or find the queue full.
    pub lost: bool,
    /// Whether there is a queue of unknown length, which may delay them more, or drop them.
    pub queued: bool,
}

impl Stay {
    /// The delay of a packet that enters at this instant alone.
    pub(crate) fn at(t_ns: u64, delay_ns: u64) -> Stay {
        Stay {
            end_ns: t_ns.saturating_add(1),
            ..Stay::always(delay_ns)
        }
    }

    /// The same delay from now on.
    pub(crate) fn always(delay_ns: u64) -> Stay {
        Stay {
            level_ns: delay_ns,
            held_until_ns: 0,
            end_ns: u64::MAX,
        }
    }

    /// The delay of a packet that enters at an instant of the piece. It never grows within the piece, and falls by no
    /// more than a second each second.
    #[inline]
    #[must_use]
    pub fn delay_ns(self, t_ns: u64) -> u64 {
        t_ns.saturating_add(self.level_ns).max(self.held_until_ns) - t_ns
    }

    /// The same, from link time to the machine's clock, on which link time begins at `origin`.
    #[inline]
    pub(crate) fn seen_from(self, origin: Epoch) -> Stay {
        let seen_ns = |t_ns| origin.t_ns(LinkTime::from_ns(t_ns));
        Stay {
            held_until_ns: seen_ns(self.held_until_ns),
            end_ns: seen_ns(self.end_ns),
            ..self
        }
    }
}
