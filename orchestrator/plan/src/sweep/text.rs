//! A sweep as a plan has it: what its axes are given, as words, with what all its runs have in common.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::axis::Axis;

/// A sweep as text. Its links and systems have the names of a plan's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepText {
    /// How long the controller sends, in ns.
    pub duration_ns: u64,
    /// How often each point is run.
    pub repeats: u32,
    /// Cost of a squared command relative to a squared error.
    pub rho: f64,
    /// How long a made link's jitter stays as it is, on average, in ns.
    pub hold_ns: u64,
    /// The words of each axis that has any: names, numbers with their units, steps between two numbers.
    pub axes: BTreeMap<Axis, Vec<String>>,
}
