//! Echoes beside the messages: packets of their own through the same link, answered by the plant's
//! kernel at once.
//!
//! They take part in the queue of a rate limit as messages do, and in nothing else.

/// An echo's IP packet, there and back, as the prober of real runs sends it.
pub(crate) const ECHO_BYTES: u32 = 84;

/// When a series of echoes begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At this virtual time.
    At(u64),
    /// When the last message has ended.
    AfterLast,
}

/// Echoes, one at an instant of each interval that the link's seed draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Series {
    /// When the first is sent.
    pub start: Start,
    /// From one to the next, ns.
    pub interval_ns: u64,
    /// Number of echoes.
    pub count: u32,
}

/// One echo. Times are virtual; what is lost has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Echo {
    /// Its number in its series, from 0.
    pub seq: u32,
    /// When it was sent.
    pub t_send_ns: u64,
    /// When it reached the plant.
    pub t_reach_ns: Option<u64>,
    /// When it was back.
    pub t_back_ns: Option<u64>,
}
