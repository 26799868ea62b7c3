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
/// runs alone is run up to `tries` times. Returns those beside others that were disturbed, in the queue's order: one
/// that is repeated at once would start up while others beside it are measured.
///
/// Each worker is a thread that outlives the programs that it starts.
///
/// # Errors
/// When a program cannot be started or waited for, or a manifest cannot be read.
pub fn run<'a>(
    queue: &Queue<'a>,
    campaign: &Path,
    program: &dyn Program,
    tries: u8,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<Vec<&'a Cell>, Error> {
    let mut disturbed = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..queue.workers())
            .map(|_| {
                scope.spawn(|| {
                    let mut disturbed = Vec::new();
                    while let Some(turn) = queue.next(stop) {
                        let outcome = run_one(&turn, campaign, program, tries, stop, progress);
                        queue.end();
                        if outcome? == Verdict::Disturbed && turn.together > 1 {
                            disturbed.push(turn.cell);
                        }
                    }
                    Ok::<_, Error>(disturbed)
                })
            })
            .collect();
        workers.into_iter().try_fold(Vec::new(), |mut all, worker| {
            let ended = worker.join();
            all.extend(ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
            Ok::<_, Error>(all)
        })
    })?;
    disturbed.sort_by_key(|cell| (cell.repeat, cell.index));
    Ok(disturbed)
}

/// Runs one cell.
fn run_one(
    turn: &Turn<'_>,
    campaign: &Path,
    program: &dyn Program,
    tries: u8,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<Verdict, Error> {
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
) -> Result<Verdict, Error> {
    let (verdict, reason) = match Manifest::read(&campaign.join(cell.folder()))? {
        Some(manifest) => (manifest.verdict, manifest.reasons.join("; ")),
        None => (Verdict::Failed, said),
    };
    progress.on_ended(cell, verdict, &reason);
    Ok(verdict)
}

#[cfg(test)]
mod tests;
