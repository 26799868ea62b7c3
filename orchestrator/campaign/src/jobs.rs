//! Runs the cells of a queue, as many at a time as the queue allows, each by a program of its own.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use plan::Verdict;

use crate::error::Error;
use crate::progress::{Begun, Progress};
use crate::queue::{Queue, Turn};

/// How often to check on a cell's program and the stop flag.
const POLL: Duration = Duration::from_millis(20);

/// A program that runs a cell and writes its manifest.
pub trait Program: Sync {
    /// Starts the program for a cell. It runs the cell up to `tries` times, while the cell is
    /// disturbed.
    ///
    /// # Errors
    /// When it cannot be started.
    fn start(&self, turn: &Turn<'_>, tries: u8) -> Result<Box<dyn Running>, Error>;
}

/// A running program.
pub trait Running {
    /// The program's last words once it has ended; `None` while it runs.
    ///
    /// # Errors
    /// When its state cannot be determined.
    fn ended(&mut self) -> Result<Option<String>, Error>;
    /// Tells it to end. May be called more than once.
    fn terminate(&mut self);
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

/// Runs one cell; tells its program to end once `stop` is set.
fn run_one(
    turn: &Turn<'_>,
    campaign: &Path,
    program: &dyn Program,
    tries: u8,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let cell = turn.cell;
    // A repeated cell would start up while others beside it are measured.
    let tries = if turn.together == 1 { tries } else { 1 };
    let begun = Begun::new(progress, cell);
    let mut running = program.start(turn, tries)?;
    let said = loop {
        if let Some(said) = running.ended()? {
            break said;
        }
        if stop.load(Ordering::Relaxed) {
            running.terminate();
        }
        std::thread::sleep(POLL);
    };
    drop(begun);
    let (verdict, reason) = match backend::manifest(campaign, cell).map_err(Error::Manifest)? {
        Some(manifest) => (manifest.verdict, manifest.reasons.join("; ")),
        // Without a manifest, the program's last words are the only reason known.
        None => (Verdict::Failed, said),
    };
    progress.on_ended(cell, verdict, &reason);
    Ok(())
}

#[cfg(test)]
mod tests;
