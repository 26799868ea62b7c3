//! What agent and orchestrator send each other, as JSON.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::name::AgentName;
use process::UNSUPPORTED;

/// The header with the length of the whole file, sent with a part of it.
pub(crate) const SIZE_HEADER: &str = "x-size";

/// Maximum number of bytes of a file in one answer.
pub(crate) const PART_BYTES: u64 = 1 << 20;

/// Answer to a health check, which anyone may ask for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Name of the agent.
    pub agent: AgentName,
    /// Its version of webloop.
    pub webloop: String,
    /// Whether an orchestrator has claimed it.
    pub claimed: bool,
}

/// A request to start a role.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StartRole {
    pub(crate) role: String,
    /// The role's settings. Only the role reads them.
    pub(crate) settings: serde_json::Value,
}

/// Answer when a role is ready.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Started {
    pub(crate) ready: String,
}

/// State of a role.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum RoleState {
    /// It runs.
    Running,
    /// It has ended.
    Ended {
        /// Its exit code; 128 plus the signal's number if a signal ended it, as in a shell.
        code: i32,
        /// Why it did not end well, as far as its log says; empty if it ended well.
        words: String,
    },
}

/// Why a request was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Problem {
    pub(crate) problem: String,
    pub(crate) kind: ProblemKind,
}

/// What a problem means for the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProblemKind {
    /// The machine there lacks something.
    Unsupported,
    /// It was tried and failed.
    Failed,
    /// The request was wrong.
    Usage,
}

impl ProblemKind {
    /// The kind of failure of a role that ended with this exit code.
    pub(crate) fn of_exit(code: i32) -> ProblemKind {
        match code {
            2 => ProblemKind::Usage,
            UNSUPPORTED => ProblemKind::Unsupported,
            _ => ProblemKind::Failed,
        }
    }
}

impl fmt::Display for ProblemKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            ProblemKind::Unsupported => "unsupported",
            ProblemKind::Failed => "failed",
            ProblemKind::Usage => "usage",
        })
    }
}
