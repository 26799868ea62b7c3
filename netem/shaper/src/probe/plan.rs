//! The echoes of a probe and their instants.

use std::net::Ipv4Addr;

use serde::{Deserialize, Serialize};

/// The echoes to send and their instants.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbePlan {
    /// The address to probe: [`PLANT_ADDRESS`](crate::PLANT_ADDRESS), or 127.0.0.1 without a link.
    pub target: Ipv4Addr,
    /// When the first echo is sent, monotonic. An instant in the past means now.
    pub start_ns: u64,
    /// Interval between echoes.
    pub interval_ns: u64,
    /// Number of echoes.
    pub count: u32,
    /// With a seed each echo is sent at an instant of its interval drawn from the seed, so that no periodic
    /// disturbance can always fall between echoes. Without a seed it is sent at the beginning.
    pub seed: Option<u64>,
    /// The echoes that the link is to lose, in order: nobody waits for them beyond `back_ns`.
    pub lost: Vec<u32>,
    /// Time from `start_ns` until the last echo is back on the link that it should meet; one that this link would
    /// lose counts too, since it may come.
    pub back_ns: u64,
    /// How long to wait beyond that while answers are missing.
    pub grace_ns: u64,
    /// Distinguishes probes: a probe needs another id if one runs at the same time, or ran before and
    /// may still have answers under way.
    pub id: u16,
}

impl ProbePlan {
    /// When echo `seq` is sent, in a series that begins at `start_ns`; later than the one before.
    #[must_use]
    pub fn due_ns(&self, start_ns: u64, seq: u32) -> u64 {
        let begin_ns = start_ns.saturating_add(u64::from(seq).saturating_mul(self.interval_ns));
        let within_ns = self.seed.map_or(0, |draws| {
            link::within_ns(draws, self.id, seq, self.interval_ns)
        });
        begin_ns.saturating_add(within_ns)
    }
}
