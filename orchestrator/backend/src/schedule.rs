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

pub(crate) use plan::series::{Series, after, before, during, empty};
use plan::{Client, START_AT_NS};

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

/// What a run takes beyond the client's own duration from the link's epoch on, typically: for the time
/// that is left.
pub const AFTER_EPOCH_NS: u64 = START_AT_NS + 1_700 * MS;

/// From a cell's start to its link's epoch, on this machine, typically.
#[must_use]
pub fn lead_ns(client: Client) -> u64 {
    LEAD_NS + ns(client.spec().start_time)
}

/// From a cell's start to the next one's of its batch. Nobody is measured meanwhile, so they may
/// overlap: half of what a client needs between two busy cores, and what the other parts need.
#[must_use]
pub fn stagger_ns(client: Client) -> u64 {
    300 * MS + ns(client.spec().start_time) / 2
}

/// What a run takes beyond the client's own duration, typically: for the time that is left.
#[must_use]
pub fn overhead_ns(client: Client) -> u64 {
    lead_ns(client) + AFTER_EPOCH_NS
}
