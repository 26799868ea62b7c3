//! When the steps of a run happen, in link time.
//!
//! ```text
//!   empty link         1.18 s         1.3 s                         end
//!   ├ parts, echoes ─ ─ ┼ echoes before ┼ controller, echoes during ──┼ echoes after ─ stop
//!                     opens
//! ```
//!
//! The controller starts at a fixed link time, so that every client meets the same bad second. What the link
//! would have done before it opens is passed over.

use std::time::Duration;

use plan::Client;
pub(crate) use plan::series::{Series, Spacing, during};

const MS: u64 = 1_000_000;

/// Time from the start of the first part until the link opens, on this machine, beside the allowance: what the
/// echoes on the empty link take, during which the other parts start, and some more.
const LEAD_NS: u64 = 150 * MS;

/// Time from now until the link of a probe opens, ns: enough for a busy machine too.
pub(crate) const PROBE_LEAD_NS: u64 = 1_000 * MS;

/// Time from the start of the first part until the link opens, ns, without the allowance, if the client takes
/// `start_time` to start. A client that takes seconds also varies by more.
pub(crate) fn lead_for_ns(start_time: Duration) -> u64 {
    LEAD_NS + ns(start_time).saturating_mul(9) / 8
}

/// A run whose parts are not ready when its link opens is begun again, with three times the patience; this is the
/// most.
pub(crate) const MOST_PATIENCE: u64 = 9;

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

/// Typical time that a run takes from the link's opening on, in addition to the client's own duration,
/// ns. It serves to estimate the time that is left.
pub const AFTER_OPENING_NS: u64 = 400 * MS;

/// Typical time from a cell's start until its link opens, on this machine, ns.
#[must_use]
pub fn lead_ns(client: Client) -> u64 {
    lead_for_ns(client.spec().start_time)
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
    lead_ns(client) + AFTER_OPENING_NS
}
