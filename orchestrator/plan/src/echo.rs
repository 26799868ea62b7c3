//! What is known of a link in a run, echo by echo: what a back-end leaves in `probes.csv` and the
//! analysis reads.
//!
//! It lives here because those two do not know each other.

use serde::{Deserialize, Serialize};

/// One echo through the link. Times are monotonic; an empty one did not come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProbeRow {
    /// When in the run it was sent.
    pub phase: Phase,
    /// Its number in its phase, from 0.
    pub seq: u32,
    /// When it was sent.
    pub t_send_ns: u64,
    /// When it reached the plant.
    pub t_reach_ns: Option<u64>,
    /// When it was back; empty if it was lost.
    pub t_back_ns: Option<u64>,
    /// The delay that the link had for it on the way up.
    pub due_up_ns: u64,
    /// The delay that the link had for it on the way down.
    pub due_down_ns: u64,
    /// Whether the link was to lose it.
    pub due_lost: bool,
}

impl ProbeRow {
    /// The columns of `probes.csv`, in order.
    pub const COLUMNS: &[&str] = &[
        "phase",
        "seq",
        "t_send_ns",
        "t_reach_ns",
        "t_back_ns",
        "due_up_ns",
        "due_down_ns",
        "due_lost",
    ];
}

/// When in a run an echo was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// On the empty link, before link time 0.
    Empty,
    /// Before the controller's first message.
    Before,
    /// While the controller sends.
    During,
    /// After it ended.
    After,
}
