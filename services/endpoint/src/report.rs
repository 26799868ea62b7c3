//! What each role reports at its end, as written to its file: data without behaviour, shared by
//! readers and writers of a run.
//!
//! Each type rejects unknown fields by name.

mod controller;
mod page;
mod plant;
mod visit;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::setting::Policy;
pub use controller::{ControllerGranted, Native, Own, Python};
pub use page::{Clock, Page, PageAsked};
pub use plant::{Plant, PlantGranted, PlantProgram};
pub use visit::{Browser, Confinement, Engine, Sandbox, Session, Version, Visit};

/// What a journal did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// Rows in the file.
    pub rows: u64,
    /// Rows that found the ring full and are not in the file.
    pub overflow: u64,
}

/// What a thread asked for and what it has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scheduling {
    /// The `SCHED_FIFO` priority asked for (1 to 99); none if not asked.
    pub asked_priority: Option<u8>,
    /// The class that the thread has.
    pub policy: Policy,
    /// Its real-time priority; 0 in the ordinary class.
    pub priority: i32,
    /// How late the kernel may let its timers be, to gather them. A `SCHED_FIFO`
    /// thread has none, whatever this says.
    pub slack_ns: u64,
    /// Why less was granted than was asked.
    pub refused: Option<String>,
}

impl Scheduling {
    /// What was asked for, the `SCHED_FIFO` priority that the thread has, if any, the slack of its timers, and why
    /// it has less.
    #[must_use]
    pub fn new(
        asked_priority: Option<u8>,
        fifo_priority: Option<i32>,
        slack_ns: u64,
        refused: Option<String>,
    ) -> Self {
        Self {
            asked_priority,
            policy: fifo_priority.map_or(Policy::Other, |_| Policy::Fifo),
            priority: fifo_priority.unwrap_or(0),
            slack_ns,
            refused,
        }
    }
}
