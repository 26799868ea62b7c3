//! Runs the cells of a queue in virtual time, on threads of this process.
//!
//! Nothing is measured there, so cells need no process of their own. The threads only simulate; meanwhile this one
//! gives the finished cells their manifests, as many at a time as are waiting, since a disk takes about as long to
//! bring one of them to safety as to bring many.

use std::any::Any;
use std::fs::File;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use analysis::campaign::Fresh;
use analysis::{CellFacts, Metrics};
use plan::{Cell, Plan};
use record::{Held, Made, Manifest, file};

use crate::error::Error;
use crate::jobs::tell;
use crate::open_error::FullError;
use crate::progress::{Begun, Progress};
use crate::queue::Queue;
use crate::threads;
use crate::tries::{self, CellRun};

/// Cells that may wait for their manifests: each has its folder open.
const WAITING: usize = 64;

/// Most cells of a plan whose metrics are kept until all have been run: a kilobyte each.
const FRESH_CELLS: usize = 5_000;

/// Runs the cells of a plan into the campaign's folder until all have ended or `stop` is set. A cell that panics has
/// failed, and the others go on. `words` says what an error means. Returns the metrics of the cells, unless they are
/// more than [`FRESH_CELLS`].
///
/// # Errors
/// When the campaign's folder cannot be brought onto the disk, or a manifest cannot be read.
pub fn simulate(
    queue: &Queue<'_>,
    plan: &Plan,
    how: &CellRun<'_>,
    stop: &AtomicBool,
    progress: &dyn Progress,
    words: fn(Error) -> String,
) -> Result<Fresh, Error> {
    let fresh = Mutex::new(Fresh::new());
    let make = |cell: &Cell| {
        let mut made = tries::make(plan, cell, how, stop)?;
        // Whether they are used or not, they are not to wait in memory for the manifest.
        let rows = made.as_mut().and_then(Made::take_rows);
        if let (Some(made), Some(rows)) = (&made, rows)
            && plan.cells.len() <= FRESH_CELLS
            && let Some(metrics) = metrics(plan, cell, made.manifest(), &rows)
        {
            let mut fresh = fresh.lock().unwrap_or_else(PoisonError::into_inner);
            fresh.insert(cell.index, metrics);
        }
        Ok(made)
    };
    run(queue, how.campaign, make, stop, progress, words)?;
    Ok(fresh.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The metrics of a cell by its rows.
fn metrics(plan: &Plan, cell: &Cell, manifest: &Manifest, rows: &Held) -> Option<Metrics> {
    let system = plan.system(cell).ok()?;
    Metrics::of(
        rows,
        &CellFacts::new(cell, &system, Some(manifest.start_ns)),
    )
}

/// Runs the cells of a queue by `make`; `None` if there is nothing to do.
fn run(
    queue: &Queue<'_>,
    campaign: &Path,
    make: impl Fn(&Cell) -> Result<Option<Made>, Error> + Sync,
    stop: &AtomicBool,
    progress: &dyn Progress,
    words: fn(Error) -> String,
) -> Result<(), Error> {
    let disk = File::open(campaign)?;
    let next = || {
        let turn = queue.next(stop)?;
        let begun = Begun::new(progress, turn.cell);
        let made = catch_unwind(AssertUnwindSafe(|| make(turn.cell)));
        let made = match made {
            Ok(made) => made.map_err(Unmade::Failed),
            Err(panic) => Err(Unmade::Panicked(last_words(&*panic))),
        };
        drop(begun);
        queue.end();
        Some((turn.cell, made))
    };
    threads::spread(
        queue.workers(),
        WAITING,
        || next,
        |made| {
            while let Ok(first) = made.recv() {
                let all = std::iter::once(first).chain(made.try_iter());
                keep(all.collect(), campaign, &disk, progress, words)?;
            }
            // The names of the last ones.
            file::sync_all(&disk).map_err(|source| full(campaign, source))
        },
    )
}

/// Why there is nothing of a cell.
enum Unmade {
    Failed(Error),
    /// Its thread did; what it said.
    Panicked(String),
}

/// Gives cells their manifests, and tells of them.
fn keep(
    cells: Vec<(&Cell, Result<Option<Made>, Unmade>)>,
    campaign: &Path,
    disk: &File,
    progress: &dyn Progress,
    words: fn(Error) -> String,
) -> Result<(), Error> {
    let (mut kept, mut made) = (Vec::new(), Vec::new());
    for (cell, outcome) in cells {
        match outcome {
            Ok(Some(one)) => {
                kept.push(cell);
                made.push(one);
            }
            Ok(None) => {
                tell(cell, campaign, String::new(), progress)?;
            }
            Err(Unmade::Failed(problem)) => {
                tell(cell, campaign, words(problem), progress)?;
            }
            Err(Unmade::Panicked(said)) => {
                tell(cell, campaign, said, progress)?;
            }
        }
    }
    for (cell, manifest) in kept.into_iter().zip(Made::keep_together(made, disk)) {
        match manifest {
            Ok(manifest) => {
                progress.on_ended(cell, manifest.verdict, &manifest.reasons.join("; "));
            }
            Err(problem) => {
                tell(cell, campaign, words(problem.into()), progress)?;
            }
        }
    }
    Ok(())
}

fn full(campaign: &Path, source: io::Error) -> Error {
    let path = campaign.to_owned();
    FullError { path, source }.into()
}

/// What a thread said as it panicked.
fn last_words(panic: &(dyn Any + Send)) -> String {
    let words = panic.downcast_ref::<&str>().copied();
    let words = words.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("its thread panicked: {}", words.unwrap_or("no words"))
}

#[cfg(test)]
mod tests;
