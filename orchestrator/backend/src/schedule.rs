//! When what happens in a run, in time since the link's epoch.
//!
//! ```text
//!   empty link        0.1 s            1.3 s                          end
//!   ├ probes, warm-up ┼ probes before ─┼ controller, probes during ───┼ probes after ─ stop
//!                   epoch
//! ```
//!
//! The controller starts at a fixed link time, so every client meets the same bad second.

use std::time::Duration;

use plan::{Client, Phase, START_AT_NS};

use crate::client;

const MS: u64 = 1_000_000;

/// From the first part's start to the epoch, on this machine: what two busy cores need to start
/// the three of them (150 ms) and to measure the empty link (300 ms), doubled.
pub(crate) const LEAD_NS: u64 = 1_000 * MS;

/// Beyond that, for a machine or a container engine that is slow: ten times what the first step
/// of a run took, since there are four parts to be started and a series of echoes to be sent,
/// and not all are equally quick.
pub(crate) fn allowance_ns(first_step: Duration) -> u64 {
    ns(first_step).saturating_mul(10)
}

/// A length of time in ns.
pub(crate) fn ns(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// A series of echoes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Series {
    /// What the rows call it.
    pub(crate) phase: Phase,
    /// When the first leaves, monotonic.
    pub(crate) start_ns: u64,
    /// From one to the next.
    pub(crate) interval_ns: u64,
    /// How many.
    pub(crate) count: u32,
}

/// The empty link's own cost: a median of sixty.
pub(crate) fn empty(now_ns: u64) -> Series {
    Series {
        phase: Phase::Empty,
        start_ns: now_ns,
        interval_ns: 5 * MS,
        count: 60,
    }
}

/// Whether the link is the one asked for, before the loop is on it: one second.
pub(crate) fn before(epoch_ns: u64) -> Series {
    Series {
        phase: Phase::Before,
        start_ns: epoch_ns + 100 * MS,
        interval_ns: 20 * MS,
        count: 50,
    }
}

/// Whether it stays so while the loop is on it: ten echoes a second, few beside its messages.
pub(crate) fn during(start_ns: u64, duration_ns: u64) -> Series {
    let interval_ns = 100 * MS;
    let count = u32::try_from(duration_ns / interval_ns).unwrap_or(u32::MAX);
    Series {
        phase: Phase::During,
        start_ns,
        interval_ns,
        count,
    }
}

/// Whether it still is so afterwards: one second.
pub(crate) fn after(now_ns: u64) -> Series {
    Series {
        phase: Phase::After,
        start_ns: now_ns,
        interval_ns: 20 * MS,
        count: 50,
    }
}

/// What a run takes beyond the client's own duration, typically: for the time that is left.
#[must_use]
pub fn overhead_ns(client: Client) -> u64 {
    LEAD_NS + ns(client::start_time(client)) + START_AT_NS + 1_700 * MS
}
