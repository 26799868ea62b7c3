//! The reports of the native controller, of the one in Python, and on one of somebody's own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Scheduling, Written};
use crate::controller::Counts;
use crate::setting::Transport;

/// What the native controller tells when it has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Native {
    /// The first deadline, on the run's clock.
    pub start_ns: u64,
    /// Where the deadlines ended.
    pub stop_ns: u64,
    /// What became of the deadlines.
    pub counts: Counts,
    /// Why the first message failed that did.
    pub first_failure: Option<String>,
    /// Whether it was stopped before its time. Messages under way then
    /// count as failed.
    pub interrupted: bool,
    /// Rows of `messages.csv`.
    pub rows: Written,
    /// What the kernel granted.
    pub granted: ControllerGranted,
}

/// What the kernel granted to a controller.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerGranted {
    /// To its thread.
    pub controller: Scheduling,
    /// Files and sockets that may be open.
    pub open_files: u64,
}

/// What the controller in Python tells when it has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Python {
    /// The first deadline, on the run's clock.
    pub start_ns: u64,
    /// Where the deadlines ended.
    pub stop_ns: u64,
    /// What became of the deadlines.
    pub counts: Counts,
    /// Why the first message failed that did.
    pub first_failure: Option<String>,
    /// Whether it was stopped before its time.
    pub interrupted: bool,
    /// Rows of `messages.csv`.
    pub rows: Written,
    /// What the kernel granted.
    pub granted: ControllerGranted,
    /// `python`.
    pub client: String,
    /// The language's version.
    pub python: String,
    /// The implementation of Python, such as `CPython`.
    pub implementation: String,
    /// What carried the messages.
    pub transport: Transport,
    /// Connections opened, those of the warm-up among them.
    pub connections: u64,
}

/// What its supervisor tells of a controller of somebody's own when it has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Own {
    /// Its name in the plan.
    pub client: String,
    /// The program and its arguments.
    pub run: Vec<String>,
    /// When its first message was due, on the run's clock.
    pub start_ns: u64,
    /// When its messages were no longer due.
    pub stop_ns: u64,
    /// When it had ended.
    pub end_ns: u64,
    /// Its exit code; for one that a signal ended, 128 and the signal's number.
    pub code: i32,
    /// Whether it was stopped before its time.
    pub interrupted: bool,
    /// Whether it did not end on SIGTERM, and was killed.
    pub killed: bool,
    /// Most bytes of answers that it had left unread at one time.
    pub unread_bytes: u64,
}
