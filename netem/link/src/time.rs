//! The two times of a run, and where they meet.
//!
//! A link is a function of its own time, which begins with 0; programs, rows and packets have the
//! machine's monotonic clock, whose instants are numbers `t_ns` throughout. An [`Epoch`] is where the
//! one begins on the other, and the only way between them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An instant of link time, to the nanosecond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LinkTime(u64);

impl LinkTime {
    /// When the link begins.
    pub const ZERO: Self = Self(0);

    /// The instant so many ns after link time 0.
    #[must_use]
    pub const fn from_ns(ns: u64) -> Self {
        Self(ns)
    }

    /// How many ns after link time 0.
    #[must_use]
    pub const fn ns(self) -> u64 {
        self.0
    }

    /// The instant `span_ns` later, or the last that there is.
    #[must_use]
    pub const fn after(self, span_ns: u64) -> Self {
        Self(self.0.saturating_add(span_ns))
    }

    /// The time from `earlier` to this instant in ns; 0 where that is not earlier.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// The monotonic instant of link time 0.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(transparent)]
pub struct Epoch(u64);

impl Epoch {
    /// The epoch at a monotonic instant.
    #[must_use]
    pub const fn at_ns(t_ns: u64) -> Self {
        Self(t_ns)
    }

    /// The monotonic instant of a link time, or the last that there is.
    #[must_use]
    pub const fn t_ns(self, at: LinkTime) -> u64 {
        self.0.saturating_add(at.0)
    }

    /// The link time of a monotonic instant; `None` before link time 0.
    #[must_use]
    pub const fn link_time(self, t_ns: u64) -> Option<LinkTime> {
        match t_ns.checked_sub(self.0) {
            Some(ns) => Some(LinkTime(ns)),
            None => None,
        }
    }
}
