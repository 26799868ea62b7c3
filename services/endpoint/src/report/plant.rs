//! The plant's report.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Scheduling, Written};

/// What a plant tells when it has stopped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// Where it listened.
    pub address: SocketAddr,
    /// When tick 0 was due, on the run's clock.
    pub start_ns: u64,
    /// Number of ticks done.
    pub ticks: u64,
    /// Ticks that came a whole sample time late or more, and were caught up.
    pub missed: u64,
    /// Commands that arrived, whatever became of them.
    pub arrivals: u64,
    /// Requests that were refused, with a 4xx or 5xx, messages over a WebSocket that ended it, and
    /// commands that were dropped as stale or aged.
    pub refused: u64,
    /// The same by kind.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub refusals: BTreeMap<String, u64>,
    /// How often the watchdog tripped.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub trips: u64,
    /// Number of connections accepted.
    pub connections: u64,
    /// Rows of `ticks.csv`.
    pub tick_rows: Written,
    /// Rows of `second.csv`, where there is a second input or output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_rows: Option<Written>,
    /// Rows of `arrivals.csv`.
    pub arrival_rows: Written,
    /// Sessions that pages have held.
    pub sessions: u64,
    /// Rows of `messages.csv`, of all sessions.
    pub page_rows: Written,
    /// What the kernel granted.
    pub granted: PlantGranted,
    /// What became of the steps, where the model is a program of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<PlantProgram>,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(trips: &u64) -> bool {
    *trips == 0
}

/// The steps of a program that is a plant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlantProgram {
    /// The program and its arguments.
    pub run: Vec<String>,
    /// Number of steps done.
    pub steps: u64,
    /// Steps that took longer than h.
    pub slow: u64,
    /// How long the slowest step took, ns.
    pub slowest_ns: u64,
}

/// What the kernel granted to the two threads that are in the loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlantGranted {
    /// To the thread that steps the model.
    pub ticker: Scheduling,
    /// To the thread that speaks HTTP.
    pub server: Scheduling,
    /// Files and sockets that may be open.
    pub open_files: u64,
}
