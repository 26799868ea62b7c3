//! Runs the cells of a queue, as many at a time as the queue allows, each by a program of its own.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use plan::{Cell, Verdict};
use record::Manifest;

use crate::error::Error;
use crate::progress::{Begun, Progress};
use crate::queue::{Queue, Turn};

/// A program that runs a cell and writes its manifest.
pub trait Program: Sync {
    /// Runs a cell up to `tries` times, while the cell is disturbed; ends it once `stop` is set.
    /// Returns the program's last words.
    ///
    /// # Errors
    /// When it cannot be started or waited for.
    fn run(&self, turn: &Turn<'_>, tries: u8, stop: &AtomicBool) -> Result<String, Error>;
}

/// Runs the cells into the campaign's folder until all have ended or `stop` is set. A cell that
/// runs alone is run up to `tries` times.
///
/// Each worker is a thread that outlives the programs that it starts.
///
/// # Errors
/// When a program cannot be started or waited for, or a manifest cannot be read.
pub fn run(
    queue: &Queue<'_>,
    campaign: &Path,
    program: &dyn Program,
    tries: u8,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<(), Error> {
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..queue.workers())
            .map(|_| {
                scope.spawn(|| {
                    while let Some(turn) = queue.next(stop) {
                        let outcome = run_one(&turn, campaign, program, tries, stop, progress);
                        queue.end();
                        outcome?;
                    }
                    Ok(())
                })
            })
            .collect();
        workers.into_iter().try_for_each(|worker| {
            worker
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    })
}

/// Runs one cell.
fn run_one(
    turn: &Turn<'_>,
    campaign: &Path,
    program: &dyn Program,
    tries: u8,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<(), Error> {
    // A repeated cell would start up while others beside it are measured.
    let tries = if turn.together == 1 { tries } else { 1 };
    let begun = Begun::new(progress, turn.cell);
    let said = program.run(turn, tries, stop)?;
    drop(begun);
    tell(turn.cell, campaign, said, progress)
}

/// Tells of a cell that has ended by its manifest. Without one, the last words of whoever ran it are the only reason
/// known.
pub(crate) fn tell(
    cell: &Cell,
    campaign: &Path,
    said: String,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let (verdict, reason) = match Manifest::read(&campaign.join(cell.folder()))? {
        Some(manifest) => (manifest.verdict, manifest.reasons.join("; ")),
        None => (Verdict::Failed, said),
    };
    progress.on_ended(cell, verdict, &reason);
    Ok(())
}

#[cfg(test)]
mod tests;
