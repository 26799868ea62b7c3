//! What the tc player reports on its way: a row each second, and a report at the end.

use crate::time::Epoch;
use crate::way::Way;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::certificate::lateness::Lateness;
use crate::certificate::prediction::Edge;
use crate::certificate::report::WayReport;
use crate::certificate::scheduling::Scheduling;

text::row!(
    /// One second of a way that tc plays: a row of `link.csv`. The counts are of that second
    /// alone, so that a column can be summed.
    TcRow {
        /// When the counters were read, monotonic.
        t_ns: u64,
        /// From controller to plant, or back.
        way: Way,
        /// Packets that left, ARP and the like included.
        delivered: u64,
        /// Their length, without Ethernet headers.
        bytes: u64,
        /// Packets that the link lost.
        lost: u64,
        /// Packets that may have found the link's queue full.
        overflow: u64,
        /// Packets that the player may have lost, which it must not.
        dropped: u64,
        /// Packets in netem at the end of the second.
        queued: u64,
        /// Changes of netem's setting.
        changes: u64,
        /// Mean lateness of these; 0 if there were none.
        late_mean_us: f64,
        /// Greatest lateness of a change.
        late_max_us: f64,
    }
);

/// What the tc player did on its way.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TcReport {
    /// What `tc -V` says.
    pub tc: String,
    /// The kernel's release.
    pub kernel: String,
    /// What the kernel granted the player's thread, and with it tc.
    pub scheduling: Scheduling,
    /// The monotonic instant of link time 0.
    #[serde(rename = "epoch_ns")]
    pub epoch: Epoch,
    /// When it began to play, monotonic.
    pub started_ns: u64,
    /// When it ended, monotonic.
    pub ended_ns: u64,
    /// The interface whose way out is shaped.
    pub device: String,
    /// The direction that it shaped.
    pub way: Way,
    /// The step in which a falling delay is followed.
    pub step_ns: u64,
    /// Changes of the setting that were made.
    pub changes: u64,
    /// Changes that were left out, because the next one was due already.
    pub skipped: u64,
    /// How long tc took to carry out a change and to tell what is in force then, once a
    /// second: no change took effect later than its lateness and this.
    pub answer: Lateness,
    /// What tc said of the interface before.
    pub found: Value,
    /// What it said of the first setting.
    pub first: Value,
    /// What it said at the end.
    pub last: Value,
    /// The packets. `lateness` is that of the changes, `bytes` that of the packets delivered,
    /// and nothing is `foreign`: tc shapes whatever leaves.
    pub traffic: WayReport,
}

/// An edge wider than this would let a link of another seed pass.
const WIDEST_EDGE_NS: u64 = 5_000_000;

impl TcReport {
    /// The edge of the link's states as played: the lateness at which 99 of 100 changes were handed
    /// over, plus tc's median time for a change. At least a step, at most 5 ms.
    #[must_use]
    pub fn edge(&self) -> Edge {
        let late_us = self.traffic.lateness.p99_us + self.answer.p50_us;
        let before_ns = (late_us * 1e3) as u64;
        Edge {
            before_ns: before_ns.clamp(Edge::TC.before_ns, WIDEST_EDGE_NS),
            ..Edge::TC
        }
    }
}
