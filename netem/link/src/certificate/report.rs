//! What a player reports on both ways: a row each second, and a report at the end.
//! [`played`](crate::certificate::played) has what two players report together that shape a way each.

use crate::time::Epoch;
use crate::way::Way;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::lateness::Lateness;
use crate::certificate::scheduling::Scheduling;

text::row!(
    /// One way of the link over one second: a row of `link.csv`. The counts are of that second
    /// alone, so that a column can be summed. A segment of TCP that crossed whole counts as the packets
    /// that a wire would have carried for it, each with its headers, and each as late.
    LinkRow {
        /// End of the second, monotonic.
        t_ns: u64,
        /// From controller to plant, or back.
        way: Way,
        /// IPv4 packets that entered.
        packets: u64,
        /// Their length, IP headers included.
        bytes: u64,
        /// Packets that left at the other end.
        delivered: u64,
        /// Packets that the link lost.
        lost: u64,
        /// Packets that found the link's queue full.
        overflow: u64,
        /// Frames that are not forwarded: no IPv4, or a stranger's.
        foreign: u64,
        /// Packets that the player itself lost, which it must not.
        dropped: u64,
        /// Mean lateness of the departures; 0 if there were none.
        late_mean_us: f64,
        /// Greatest lateness of a departure.
        late_max_us: f64,
    }
);

/// One way of the link over the whole play.
///
/// `packets + duplicated = delivered + lost + overflow + unplayed` and those of `dropped` that
/// were lost in sending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WayReport {
    /// IPv4 packets that entered.
    pub packets: u64,
    /// Their length, IP headers included.
    pub bytes: u64,
    /// Packets that left at the other end.
    pub delivered: u64,
    /// Packets that the link lost.
    pub lost: u64,
    /// Packets that found the link's queue full.
    pub overflow: u64,
    /// Packets that were still under way at the end.
    pub unplayed: u64,
    /// Frames that were no IPv4, or a stranger's, and are not forwarded.
    pub foreign: u64,
    /// Packets that the player itself lost: its socket was full, or sending failed. Anything
    /// but 0 makes a run invalid.
    pub dropped: u64,
    /// Packets that a fault of the link let out twice.
    #[serde(default, skip_serializing_if = "is_none")]
    pub duplicated: u64,
    /// Packets of which a fault flipped a bit.
    #[serde(default, skip_serializing_if = "is_none")]
    pub corrupted: u64,
    /// Segments of TCP that a fault made resets.
    #[serde(default, skip_serializing_if = "is_none")]
    pub reset: u64,
    /// Segments of TCP of which a fault changed the controller's port.
    #[serde(default, skip_serializing_if = "is_none")]
    pub rebound: u64,
    /// How late the departures were.
    pub lateness: Lateness,
}

/// Whether a fault concerned no packet: what was not asked for is not in a report.
#[allow(clippy::trivially_copy_pass_by_ref)] // The signature is serde's.
fn is_none(count: &u64) -> bool {
    *count == 0
}

/// A time that the player was kept from its processor, or stopped, though it had something to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pause {
    /// When it ended, monotonic.
    pub t_ns: u64,
    /// How long it was.
    pub ns: u64,
}

/// What the player did.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlayerReport {
    /// What the kernel granted the player's thread.
    pub scheduling: Scheduling,
    /// The monotonic instant of link time 0.
    #[serde(rename = "epoch_ns")]
    pub epoch: Epoch,
    /// When it began to play, monotonic.
    pub started_ns: u64,
    /// When it ended, monotonic.
    pub ended_ns: u64,
    /// When it was held up for 5 ms or more; the first hundred.
    #[serde(default)]
    pub pauses: Vec<Pause>,
    /// From controller to plant.
    pub up: WayReport,
    /// From plant to controller.
    pub down: WayReport,
}

impl PlayerReport {
    /// Packets that the player itself lost. Anything but 0 makes a run invalid.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.up.dropped + self.down.dropped
    }
}
