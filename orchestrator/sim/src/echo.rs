//! Echoes beside the messages: packets of their own through the same link, which the plant's kernel
//! answers at once.
//!
//! They queue at a rate limit as messages do, and have no other effect.

/// Length of an echo's IP packet, each way, as the prober of real runs sends it.
pub(crate) const ECHO_BYTES: u32 = 84;

/// When a series of echoes begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At this virtual time.
    At(u64),
    /// When the last message has ended.
    AfterLast,
}

/// A series of echoes: one in each interval, at an instant drawn from the link's seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Series {
    /// When the first interval begins.
    pub start: Start,
    /// Interval in ns.
    pub interval_ns: u64,
    /// Number of echoes.
    pub count: u32,
}

/// One echo. Times are virtual; a lost echo lacks those after its loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Echo {
    /// Its number in its series, from 0.
    pub seq: u32,
    /// When it was sent.
    pub t_send_ns: u64,
    /// When it reached the plant.
    pub t_reach_ns: Option<u64>,
    /// When it came back.
    pub t_back_ns: Option<u64>,
}
