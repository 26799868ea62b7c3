//! When the steps of a run happen, in time since the link's epoch.
//!
//! ```text
//!   empty link        0.1 s            1.3 s                          end
//!   ├ probes, warm-up ┼ probes before ─┼ controller, probes during ───┼ probes after ─ stop
//!                   epoch
//! ```
//!
//! The controller starts at a fixed link time, so that every client meets the same bad second.

use std::time::Duration;

pub(crate) use plan::series::{Series, after, before, during, empty};
use plan::{Client, START_AT};

const MS: u64 = 1_000_000;

/// Time from the start of the first part to the epoch, on this machine: about twice what two busy cores
/// need to start the three parts (150 ms) and to measure the empty link (300 ms).
pub(crate) const LEAD_NS: u64 = 1_000 * MS;

/// Extra time for a slow machine or container engine, ns: ten times what the first step of a run took,
/// since four parts have to be started and a series of echoes sent, and not all of them are equally
/// quick.
pub(crate) fn allowance_ns(first_step: Duration) -> u64 {
    ns(first_step).saturating_mul(10)
}

/// A length of time in ns.
pub(crate) fn ns(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Typical time that a run takes from the link's epoch on, in addition to the client's own duration,
/// ns. It serves to estimate the time that is left.
pub const AFTER_EPOCH_NS: u64 = START_AT.ns() + 1_700 * MS;

/// Typical time from a cell's start to its link's epoch, on this machine, ns.
#[must_use]
pub fn lead_ns(client: Client) -> u64 {
    LEAD_NS + ns(client.spec().start_time)
}

/// Time from the start of a cell to that of the next one in its batch, ns. Nothing is measured
/// meanwhile, so starts may overlap: half of what a client needs on two busy cores, plus what the other
/// parts need.
#[must_use]
pub fn stagger_ns(client: Client) -> u64 {
    300 * MS + ns(client.spec().start_time) / 2
}

/// Typical time that a run takes in addition to the client's own duration, ns. It serves to estimate
/// the time that is left.
#[must_use]
pub fn overhead_ns(client: Client) -> u64 {
    lead_ns(client) + AFTER_EPOCH_NS
}
