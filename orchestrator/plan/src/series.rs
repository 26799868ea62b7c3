//! When echoes are sent through the link of a run, and when the link opens for them.
//!
//! The loop meets the link from [`START_AT`] on in every back-end. Before and after it there are as many echoes
//! everywhere, but real time, in which somebody waits, has them closer together than virtual time.

use link::{Epoch, LinkTime, Profile};

use crate::cell::START_AT;
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

/// How close to each other the echoes are while no loop uses the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    /// In virtual time, and where the link has a rate limit: close echoes would queue there.
    Wide,
    /// In real time, in which somebody waits.
    Close,
}

impl Spacing {
    /// The spacing in real time.
    #[must_use]
    pub fn of(profile: &Profile) -> Spacing {
        if profile.has_rate() {
            Spacing::Wide
        } else {
            Spacing::Close
        }
    }

    /// The link time from which on the link is in force: as long before the loop as the echoes need.
    #[must_use]
    pub const fn opens(self) -> LinkTime {
        match self {
            Spacing::Wide => LinkTime::ZERO,
            Spacing::Close => LinkTime::from_ns(START_AT.ns() - 120 * MS),
        }
    }

    /// Echoes that measure the cost of the empty link, as a median of sixty.
    #[must_use]
    pub fn empty(self, now_ns: u64) -> Series {
        Series {
            phase: Phase::Empty,
            start_ns: now_ns,
            interval_ns: match self {
                Spacing::Wide => 5 * MS,
                Spacing::Close => 2 * MS,
            },
            count: 60,
        }
    }

    /// Echoes that check whether the link is the one asked for before the loop uses it.
    #[must_use]
    pub fn before(self, epoch: Epoch) -> Series {
        let after_opening_ns = match self {
            Spacing::Wide => 100 * MS,
            Spacing::Close => 5 * MS,
        };
        Series {
            phase: Phase::Before,
            start_ns: epoch.t_ns(self.opens().after(after_opening_ns)),
            interval_ns: self.interval_ns(),
            count: 50,
        }
    }

    /// Echoes that check the same after the loop has ended.
    #[must_use]
    pub fn after(self, now_ns: u64) -> Series {
        Series {
            phase: Phase::After,
            start_ns: now_ns,
            interval_ns: self.interval_ns(),
            count: 50,
        }
    }

    fn interval_ns(self) -> u64 {
        match self {
            Spacing::Wide => 20 * MS,
            Spacing::Close => 2 * MS,
        }
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
