//! When in a run echoes are sent through its link, the same in every back-end.

use crate::echo::Phase;

const MS: u64 = 1_000_000;

/// A series of echoes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Series {
    /// What the rows call it.
    pub phase: Phase,
    /// When the first leaves, monotonic.
    pub start_ns: u64,
    /// From one to the next.
    pub interval_ns: u64,
    /// How many.
    pub count: u32,
}

/// The empty link's own cost: a median of sixty.
#[must_use]
pub fn empty(now_ns: u64) -> Series {
    Series {
        phase: Phase::Empty,
        start_ns: now_ns,
        interval_ns: 5 * MS,
        count: 60,
    }
}

/// Whether the link is the one asked for, before the loop is on it: one second.
#[must_use]
pub fn before(epoch_ns: u64) -> Series {
    Series {
        phase: Phase::Before,
        start_ns: epoch_ns + 100 * MS,
        interval_ns: 20 * MS,
        count: 50,
    }
}

/// Whether it stays so while the loop is on it: ten echoes a second, few beside its messages.
#[must_use]
pub fn during(start_ns: u64, duration_ns: u64) -> Series {
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
#[must_use]
pub fn after(now_ns: u64) -> Series {
    Series {
        phase: Phase::After,
        start_ns: now_ns,
        interval_ns: 20 * MS,
        count: 50,
    }
}
