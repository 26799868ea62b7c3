//! What agent and orchestrator say to each other, as JSON.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::AgentName;

/// The header with a file's whole length, beside a part of it.
pub(crate) const SIZE_HEADER: &str = "x-size";

/// The most of a file that one answer brings.
pub(crate) const PART_BYTES: u64 = 1 << 20;

/// Who answers, for anyone who asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Name of the agent.
    pub agent: AgentName,
    /// Its version of webloop.
    pub webloop: String,
    /// Whether it has a master already.
    pub claimed: bool,
}

/// A role that is asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StartRole {
    pub(crate) role: String,
    /// The role's settings, which only the role reads.
    pub(crate) settings: serde_json::Value,
}

/// A role that is ready.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Started {
    pub(crate) ready: String,
}

/// How a role is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum RoleState {
    /// The role runs.
    Running,
    /// It has ended.
    Ended {
        /// Its exit code; 128 and the signal's number where a signal ended it, as in a shell.
        code: i32,
        /// If it did not end well: why, as far as its log says.
        words: String,
    },
}

/// Why something was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Problem {
    pub(crate) problem: String,
    pub(crate) kind: Kind,
}

/// What a problem means for who asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The machine there lacks something.
    Unsupported,
    /// It was tried and went wrong.
    Failed,
    /// It should not have been asked like that.
    Usage,
}

impl Kind {
    /// The kind of failure of a role that ended with this exit code.
    pub(crate) fn of_exit(code: i32) -> Kind {
        match code {
            2 => Kind::Usage,
            3 => Kind::Unsupported,
            _ => Kind::Failed,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Kind::Unsupported => "unsupported",
            Kind::Failed => "failed",
            Kind::Usage => "usage",
        })
    }
}
