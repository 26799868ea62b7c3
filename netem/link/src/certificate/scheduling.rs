//! How a player's thread was scheduled. The shaper requests it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the kernel schedules a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduling {
    /// `SCHED_FIFO`: ahead of every ordinary thread.
    Fifo,
    /// `SCHED_OTHER`: in turn with every other thread.
    Other,
}
