//! When echoes are sent through the link of a run; the same in every back-end.

use link::{Epoch, LinkTime};

use crate::echo::Phase;

const MS: u64 = 1_000_000;

/// A series of echoes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Series {
    /// Its name in the rows.
    pub phase: Phase,
    /// When the first echo is sent, monotonic.
    pub start_ns: u64,
    /// Time from one echo to the next.
    pub interval_ns: u64,
    /// Number of echoes.
    pub count: u32,
}

/// Echoes that measure the cost of the empty link, as a median of sixty.
#[must_use]
pub fn empty(now_ns: u64) -> Series {
    Series {
        phase: Phase::Empty,
        start_ns: now_ns,
        interval_ns: 5 * MS,
        count: 60,
    }
}

/// Echoes that check whether the link is the one asked for, for one second before the loop uses it.
#[must_use]
pub fn before(epoch: Epoch) -> Series {
    Series {
        phase: Phase::Before,
        start_ns: epoch.t_ns(LinkTime::from_ns(100 * MS)),
        interval_ns: 20 * MS,
        count: 50,
    }
}

/// Echoes that check the same while the loop uses the link: ten a second, few beside its messages.
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

/// Echoes that check the same for one second after the loop has ended.
#[must_use]
pub fn after(now_ns: u64) -> Series {
    Series {
        phase: Phase::After,
        start_ns: now_ns,
        interval_ns: 20 * MS,
        count: 50,
    }
}
