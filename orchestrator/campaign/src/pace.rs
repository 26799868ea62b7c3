//! Estimates how long cells will take, from typical times.

use std::collections::BTreeMap;
use std::time::Duration;

use plan::Cell;

use crate::queue::{batch_time, batches};

/// Time for a message in virtual time, with its rows written and read.
const VIRTUAL_MESSAGE: Duration = Duration::from_micros(4);
/// Time for a cell beyond its messages: its link, its echoes, its checksums.
const VIRTUAL_CELL: Duration = Duration::from_millis(8);

/// How fast cells run: how many at a time, and in real or virtual time.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Number of cells at a time; `None` for as many as each cell allows.
    pub jobs: Option<u16>,
    /// Whether the cells run in virtual time.
    pub is_virtual: bool,
}

impl Pace {
    /// One after another, in real time.
    pub const ALONE: Pace = Pace {
        jobs: Some(1),
        is_virtual: false,
    };
}

/// Weight of a cell when cells are divided into shards, ns: its duration, and what comes before and
/// after.
#[must_use]
pub fn time_ns(cell: &Cell) -> u64 {
    cell.duration_ns + backend::overhead_ns(cell.client)
}

/// How long these cells take at this pace, in total.
#[must_use]
pub fn expected(cells: &[&Cell], pace: Pace) -> Duration {
    shares(cells, pace).values().sum()
}

/// What each cell, by its index, adds to [`expected`]: its share of its batch's time.
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
