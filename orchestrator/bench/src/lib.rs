//! Measures webloop beside its limits and its peers, in one run.
//!
//! A [`Group`] is a table: one figure of several [`Contender`]s, of which one is the base. Each repetition
//! measures them all, one after another, and a ratio is taken within a repetition: what disturbs the
//! machine for longer than a repetition is in both of its numbers. A peer that this machine does not have
//! is named and skipped.
//!
//! - `group` has the groups with their goals; `step`, `tick`, `crossing`, `stream`, `virtual_time`, `rows` and `cell`
//!   have their contenders.
//! - `end` has what peers need at the other end; `python`, `load` and `rattan` the peers that are programs;
//!   `role` starts processes, `campaign` runs cells.
//! - [`Outcome`] and `table` are what is printed, and what is left in a folder.
//!
//! It decides nothing: whether a goal is met is printed, and is no test. Programs are measured as they
//! are run: webloop's own roles as processes of this binary.

mod campaign;
mod cell;
mod contender;
mod crossing;
mod end;
mod group;
mod load;
mod outcome;
mod processor;
mod python;
mod rattan;
mod role;
mod rows;
mod step;
mod stream;
mod table;
mod tick;
mod virtual_time;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

pub use contender::{Contender, Kind, Lack, Measured};
pub use end::{UnknownEnd, serve};
pub use group::{Goal, Group};
pub use outcome::{Outcome, Ratio, Series};
pub use processor::Processors;
pub use table::{csv, text};

/// How to measure.
#[derive(Debug)]
pub struct Settings {
    /// How often each contender is measured.
    pub times: u32,
    /// How long a contender is measured at a time, ms; a step and a tick both take that long.
    pub measure_ms: u64,
}

/// What contenders have at hand.
#[derive(Debug)]
pub struct Context<'a> {
    /// How long to measure.
    pub(crate) measure_ms: u64,
    /// The binary whose roles are measured.
    pub(crate) webloop: &'a Path,
    /// The processor for both ends of a step, and for what is compared on one processor.
    pub(crate) processors: Processors,
    /// An empty folder for this measurement.
    pub(crate) folder: PathBuf,
}

/// Measures a group. Calls `on_measured` with each contender before it is measured.
///
/// Ends early, with the repetitions that are whole, when `stop` is set.
///
/// # Errors
/// If there is no temporary folder.
pub fn measure(
    group: Group,
    settings: &Settings,
    webloop: &Path,
    stop: &AtomicBool,
    mut on_contender: impl FnMut(&str, u32),
) -> std::io::Result<Outcome> {
    let mut series: Vec<Series> = group.contenders().iter().map(Series::new).collect();
    let processors = Processors::of_this_process()?;
    'times: for time in 0..settings.times {
        for one in &mut series {
            if stop.load(Ordering::Relaxed) {
                break 'times;
            }
            if one.is_skipped() {
                continue;
            }
            on_contender(one.contender.name, time);
            let folder = tempfile::tempdir()?;
            one.add((one.contender.measure)(&Context {
                measure_ms: settings.measure_ms,
                webloop,
                processors,
                folder: folder.path().to_owned(),
            }));
        }
    }
    Ok(Outcome::new(group, series))
}
