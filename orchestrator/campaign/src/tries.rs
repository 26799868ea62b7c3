//! Runs one cell until it is not disturbed: the work of a cell's own process, or of a worker in virtual time.

use std::borrow::Borrow;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use analysis::Run;
use backend::{Attempt, Backend, Player, RunError};
use plan::{Cell, Plan, Verdict};
use record::{Made, Manifest};

use crate::earlier::Own;
use crate::error::Error;

/// How a cell is run.
#[derive(Debug)]
pub struct CellRun<'a> {
    /// The campaign's folder.
    pub campaign: &'a Path,
    /// The back-end.
    pub backend: &'a Backend,
    /// The player of the cell's link.
    pub player: Player,
    /// What earlier runs in the folder have to match.
    pub own: Own,
    /// Maximum number of tries while the cell is disturbed.
    pub tries: u8,
    /// Number of cells that run at the same time, this one included.
    pub together: u16,
}

/// How running a cell ended.
#[derive(Debug)]
pub enum Ended {
    /// It was already complete.
    Before,
    /// It has been run now.
    Now(Box<Manifest>),
    /// It was told to stop.
    Interrupted,
}

/// Runs a cell of a plan, unless it is complete already.
///
/// # Errors
/// When an earlier run is of another kind or damaged, or the folder cannot be written.
pub fn run_cell(
    plan: &Plan,
    cell: &Cell,
    how: &CellRun<'_>,
    stop: &AtomicBool,
) -> Result<Ended, Error> {
    let Some(made) = make(plan, cell, how, stop)? else {
        return Ok(Ended::Before);
    };
    let manifest = made.keep()?;
    Ok(match stop.load(Ordering::Relaxed) {
        true => Ended::Interrupted,
        false => Ended::Now(Box::new(manifest)),
    })
}

/// Runs a cell of a plan up to its manifest; `None` if it is complete already.
///
/// # Errors
/// As for [`run_cell`].
pub(crate) fn make(
    plan: &Plan,
    cell: &Cell,
    how: &CellRun<'_>,
    stop: &AtomicBool,
) -> Result<Option<Made>, Error> {
    if is_complete(plan, cell, how)? {
        return Ok(None);
    }
    // The plan says how many may run together, the manifest how many did.
    let cell = &Cell {
        together: how.together,
        ..cell.clone()
    };
    let attempt = |earlier| {
        let attempt = Attempt {
            started: jiff::Timestamp::now().to_string(),
            earlier,
        };
        backend::run_cell(
            plan,
            cell,
            how.campaign,
            how.backend,
            how.player,
            attempt,
            stop,
        )
    };
    Ok(Some(until_undisturbed(
        how.tries,
        stop,
        attempt,
        |made: Made| Ok(made.keep()?),
    )?))
}

/// Whether an earlier run of a cell, as this run would have made it, is complete.
fn is_complete(plan: &Plan, cell: &Cell, how: &CellRun<'_>) -> Result<bool, Error> {
    // Most cells have no folder yet, and to read one takes as long as a short run in virtual time.
    let folder = how.campaign.join(cell.folder());
    if let Err(problem) = folder.symlink_metadata()
        && problem.kind() == ErrorKind::NotFound
    {
        return Ok(false);
    }
    let before = Run::read(how.campaign, plan, cell);
    if let Some(manifest) = &before.manifest {
        how.own.check(plan, manifest, &before.folder)?;
    }
    match before.verdict() {
        Some(Verdict::Complete) | None if !before.damage.is_empty() => {
            let damage = before.damage.iter().map(ToString::to_string);
            Err(Error::DamagedCell(damage.collect::<Vec<_>>().join("; ")))
        }
        verdict => Ok(verdict == Some(Verdict::Complete)),
    }
}

/// Makes attempts until one is not disturbed, `tries` have been made, or `stop` is set. Each
/// attempt gets the reasons of the earlier ones, which `keep` has kept.
fn until_undisturbed<M: Borrow<Manifest>>(
    tries: u8,
    stop: &AtomicBool,
    mut attempt: impl FnMut(Vec<String>) -> Result<M, RunError>,
    keep: impl Fn(M) -> Result<Manifest, RunError>,
) -> Result<M, RunError> {
    let mut earlier: Vec<String> = Vec::new();
    loop {
        let made = attempt(earlier.clone())?;
        let is_last = earlier.len() + 1 >= usize::from(tries);
        let is_disturbed = made.borrow().verdict == Verdict::Disturbed;
        if stop.load(Ordering::Relaxed) || !is_disturbed || is_last {
            return Ok(made);
        }
        earlier.push(keep(made)?.reasons.join("; "));
    }
}

#[cfg(test)]
mod tests;
