//! What the program of a plant of somebody's own is started with.

use std::ffi::OsString;
use std::time::Duration;

use crate::shelter::Hidden;

/// A program to be started as a plant.
#[derive(Debug)]
pub struct Start<'a> {
    /// The program and its arguments.
    pub run: &'a [String],
    /// What its environment has in addition to this process's, and to the package `webloop` on Python's path.
    pub environment: Vec<(&'static str, OsString)>,
    /// How many inputs it has: 1 or 2.
    pub inputs: usize,
    /// What a step advances by, ns: a step that takes longer is counted.
    pub h_ns: u64,
    /// How long it may take from its start to its first y.
    pub start_within: Duration,
    /// How long a step may take before the program counts as broken.
    pub step_within: Duration,
    /// How far it is kept from this machine.
    pub confinement: Confinement,
}

/// How far a plant's program is kept from this machine.
#[derive(Debug, Clone)]
pub enum Confinement {
    /// It may do what this user may.
    None,
    /// What a plant does not need is taken from it, and this is hidden, where this user may do that. This process's
    /// own program must be webloop.
    Confined(Option<Hidden>),
}
