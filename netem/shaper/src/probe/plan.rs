//! The echoes of a probe and their instants.

use std::net::Ipv4Addr;

use serde::{Deserialize, Serialize};

/// The echoes to send and their instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbePlan {
    /// Whom to ask: [`PLANT_ADDRESS`](crate::PLANT_ADDRESS), or 127.0.0.1 where there is no
    /// link.
    pub target: Ipv4Addr,
    /// When the first leaves, monotonic. An instant in the past means now.
    pub start_ns: u64,
    /// The time from one to the next.
    pub interval_ns: u64,
    /// Number of echoes.
    pub count: u32,
    /// Where it is given, each leaves at an instant of its interval that is drawn by it, so that
    /// nothing that keeps a period can pass between them. Without it they leave at its beginning.
    pub seed: Option<u64>,
    /// How long after the last one answers are waited for. More than the link's longest
    /// round trip, or late answers pass for lost ones.
    pub grace_ns: u64,
    /// Tells probes apart: one that runs at the same time, or that ran before and may still
    /// have answers under way, needs another id.
    pub id: u16,
}

impl ProbePlan {
    /// When echo `seq` leaves, in a series that begins at `start_ns`; later than the one before.
    #[must_use]
    pub fn due_ns(&self, start_ns: u64, seq: u32) -> u64 {
        let begin_ns = start_ns.saturating_add(u64::from(seq).saturating_mul(self.interval_ns));
        let within_ns = self.seed.map_or(0, |draws| {
            link::within_ns(draws, self.id, seq, self.interval_ns)
        });
        begin_ns.saturating_add(within_ns)
    }
}
