//! How long cells will take, from what is typical.

use std::collections::BTreeMap;
use std::time::Duration;

use plan::Cell;

use crate::queue::{batch_time, batches};

/// What a message takes in virtual time, with its rows written and read.
const VIRTUAL_MESSAGE: Duration = Duration::from_micros(4);
/// What a cell takes beyond that: its process, its echoes, its checksums.
const VIRTUAL_CELL: Duration = Duration::from_millis(40);

/// How fast cells go: how many at a time, and in whose time.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// How many at a time, if not as many as they say themselves.
    pub jobs: Option<u16>,
    /// Whether their time is virtual.
    pub is_virtual: bool,
}

impl Pace {
    /// One after another, in real time.
    pub const ALONE: Pace = Pace {
        jobs: Some(1),
        is_virtual: false,
    };
}

/// By what cells are shared out: their length, and what comes before and after, ns.
#[must_use]
pub fn time_ns(cell: &Cell) -> u64 {
    cell.duration_ns + backend::overhead_ns(cell.client)
}

/// How long these cells take at this pace.
#[must_use]
pub fn expected(cells: &[&Cell], pace: Pace) -> Duration {
    shares(cells, pace).values().sum()
}

/// What each of these cells, by its index, adds to that: its part of its batch's.
#[must_use]
pub fn shares(cells: &[&Cell], pace: Pace) -> BTreeMap<usize, Duration> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    if pace.is_virtual {
        let jobs = u32::from(pace.jobs.unwrap_or(1).max(1));
        let share = |cell: &&Cell| {
            let messages = u32::try_from(cell.due()).unwrap_or(u32::MAX);
            let time = VIRTUAL_CELL + VIRTUAL_MESSAGE.saturating_mul(messages);
            (cell.index, time / jobs)
        };
        return cells.iter().map(share).collect();
    }
    let batches = batches(cells, pace.jobs);
    let shares = batches.iter().flat_map(|batch| {
        let share = batch_time(batch) / count(batch.len());
        batch.iter().map(move |cell| (cell.index, share))
    });
    shares.collect()
}
