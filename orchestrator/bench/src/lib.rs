//! Measures webloop beside its limits and its peers, in one run.
//!
//! A [`Group`] is a table: one figure of several contenders, of which one is the base. Each repetition
//! measures them all, one after another, and a ratio is taken within a repetition: what disturbs the
//! machine for longer than a repetition is in both of its numbers. A peer that this machine does not have
//! is named and skipped.
//!
//! - `group` has the names of the tables; `step`, `rate`, `tick`, `crossing`, `stream`, `virtual_time`, `rows`,
//!   `cell`, `memory`, `report` and `browser` have their contenders and goals.
//! - `end` has what peers need at the other end; `python`, `load` and `rattan` the peers that are programs;
//!   `role` starts processes, `campaign` runs cells.
//! - [`Outcome`] is what was measured, [`text`] and [`csv`] write it.
//!
//! It decides nothing: whether a goal is met is printed, and is no test. Programs are measured as they
//! are run: webloop's own roles as processes of this binary.

mod browser;
mod campaign;
mod cell;
mod contender;
mod crossing;
mod end;
mod group;
mod load;
mod memory;
mod outcome;
mod processor;
mod python;
mod rate;
mod rattan;
mod report;
mod role;
mod rows;
mod step;
mod stream;
mod table;
mod tick;
mod virtual_time;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

pub use end::{UnknownEnd, serve};
pub use group::Group;
pub use outcome::Outcome;
pub use table::{csv, text};

use outcome::Series;
use processor::Processors;

/// How to measure.
#[derive(Debug)]
pub struct Settings {
    /// How often each contender is measured.
    pub times: u32,
    /// How long steps, ticks, echoes and streams are measured at a time, ms.
    pub measure_ms: u64,
}

/// What contenders have at hand.
#[derive(Debug)]
pub(crate) struct Context<'a> {
    /// How long to measure.
    pub(crate) measure_ms: u64,
    /// The binary whose roles are measured.
    pub(crate) webloop: &'a Path,
    /// An empty folder for this measurement.
    pub(crate) folder: PathBuf,
}

/// Measures a table. Calls `on_contender` with each contender and the number of the repetition before it is measured.
///
/// Ends early, with what is measured by then, when `stop` is set.
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
    let table = group.table();
    let mut series: Vec<Series> = table.contenders.iter().map(Series::new).collect();
    let processors = table.processors.map(Processors::last).transpose()?;
    for time in 0..settings.times.min(group.most_times()) {
        for one in &mut series {
            if stop.load(Ordering::Relaxed) {
                return Ok(Outcome { group, series });
            }
            if one.is_skipped() {
                continue;
            }
            on_contender(one.contender.name, time);
            let folder = tempfile::tempdir()?;
            let context = Context {
                measure_ms: settings.measure_ms,
                webloop,
                folder: folder.path().to_owned(),
            };
            let measure = || (one.contender.measure)(&context);
            one.add(match &processors {
                Some(processors) => processors.run(measure),
                None => measure(),
            });
        }
    }
    Ok(Outcome { group, series })
}
