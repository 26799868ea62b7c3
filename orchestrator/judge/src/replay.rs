//! Whether the ends were the plan's: y is replayed from u by the plan's plant, and u from y by its law, r and h, by
//! the same code that steps them in a run. So all bits agree, or an end was another one.
//!
//! - `plant`: ticks, with watchdog, actuator, disturbance and the sensor's noise;
//! - `controller`: deadlines, references, outputs and commands.
//!
//! A program of one's own is nobody's to replay: the other end is, and what passes between them. What a fault killed
//! begins anew at a time that is not recorded, so it is replayed until then. [`Ends`] says how far that was.

mod controller;
mod plant;

use std::fmt;

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use plan::evidence::Ends;
use plan::system::System;
use plan::{Cell, End, EndEffect, EndFaultDone};

use self::plant::Plant;

/// The rows of both ends, and what the plan has of them.
#[derive(Debug, Clone, Copy)]
pub struct Both<'a> {
    /// The cell, with the settings of both ends.
    pub cell: &'a Cell,
    /// The plan's system.
    pub system: &'a System,
    /// Whether the plant is a program of one's own.
    pub is_plant_own: bool,
    /// When the first message was due, monotonic.
    pub start_ns: u64,
    /// What faults did to the ends.
    pub end_faults: &'a [EndFaultDone],
    /// Rows of `ticks.csv`.
    pub ticks: &'a [TickRow],
    /// Rows of `second.csv`; none if there is no second input or output.
    pub second: &'a [SecondRow],
    /// Rows of `arrivals.csv`.
    pub arrivals: &'a [ArrivalRow],
    /// Rows of `messages.csv`.
    pub messages: &'a [MessageRow],
}

/// The first row of an end that does not follow by the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Other {
    /// The end that is another one than the plan's.
    pub end: End,
    /// The row: its file and its number in it.
    pub row: String,
    /// What it has, and what follows by the plan.
    pub what: String,
}

impl fmt::Display for Other {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { end, row, what } = self;
        write!(f, "the {end} is not the plan's: in {row}, {what}")
    }
}

/// Replays both ends, and finds the first row of each that does not follow.
#[must_use]
pub fn replay(both: &Both<'_>) -> (Ends, Vec<Other>) {
    let plant = (!both.is_plant_own).then(|| plant::replay(both));
    let plant = plant.unwrap_or_default();
    let is_own = both.cell.client.is_own();
    let (commands, controller) = if is_own {
        (0, None)
    } else {
        controller::replay(both, &plant)
    };
    let Plant { ticks, other, .. } = plant;
    (
        Ends { ticks, commands },
        other.into_iter().chain(controller).collect(),
    )
}

impl Both<'_> {
    /// Until when an end can be replayed: its first kill, less the time before it of which it had not yet written
    /// all rows. What a controller had from a plant that was killed is not known either.
    fn until_ns(&self, end: End) -> u64 {
        /// Rows are written ten times a second.
        const UNWRITTEN_NS: u64 = 200_000_000;
        let concerns = |one: &&EndFaultDone| one.end == end || end == End::Controller;
        let kills = self.end_faults.iter().filter(concerns);
        let kills = kills.filter(|one| one.effect == EndEffect::Kill);
        let first_ns = kills.map(|one| one.from_ns).min();
        first_ns.map_or(u64::MAX, |ns| ns.saturating_sub(UNWRITTEN_NS))
    }
}

/// Whether two numbers are one, also if both are none. Not by their bits: JavaScript writes -0 as 0.
fn is_same(found: f64, due: f64) -> bool {
    found == due || (found.is_nan() && due.is_nan())
}

/// A difference in a sentence, if there is one.
fn differs(name: &str, found: f64, due: f64) -> Option<String> {
    (!is_same(found, due)).then(|| format!("{name} is {found:?}; by the plan it is {due:?}"))
}
