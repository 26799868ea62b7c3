//! A campaign: its results folder and the runs of its cells, or of its sweep.
//!
//! - `folder`: a folder that only one process writes to; [`CampaignFolder`] has its plan and cells in it,
//!   [`SweepFolder`] the rows of a sweep.
//! - [`pending`]: the cells still to run when a folder is continued; [`Own`]: checks that the runs
//!   already there are of this run's kind.
//! - [`Queue`]: when each cell starts; [`run`]: runs the cells of a queue, each by a [`Program`],
//!   which is a process ([`Processes`]) except in tests. [`run_cell`]: what such a process does for
//!   its cell; it runs it again while it is disturbed. [`simulate`]: the same in virtual time, on
//!   threads.
//! - [`ComposeRunner`]: runs cells in containers; [`attach`]: finds the agents in there.
//! - [`Pace`]: how long all of it will take. [`run_points`]: runs a sweep's points, each on a [`Bench`]; `threads`
//!   spreads them, and cells in virtual time.
//! - [`Sources`]: merges folders of one plan; [`Results`]: a folder's table; [`series`]: its rows
//!   in one CSV; [`calibration`]: the timings of a machine, from its rows.
//!
//! The binary handles arguments, messages to the user and exit codes. It receives [`Progress`] and
//! passes in the program of a cell and the clock.
#![forbid(unsafe_code)]

pub mod attach;
mod bench;
pub mod calibration;
mod campaign_folder;
mod containers;
mod earlier;
mod ends;
mod error;
mod folder;
mod jobs;
mod merge;
mod open_error;
pub mod owner;
mod pace;
mod points;
mod process;
mod progress;
mod queue;
mod results;
mod resume;
#[cfg(test)]
mod sample;
pub mod series;
mod sweep_folder;
mod threads;
mod tries;
mod workers;

pub use bench::{Bench, Unfit};
pub use campaign_folder::CampaignFolder;
pub use containers::{ComposeRunner, Inside};
pub use earlier::Own;
pub use error::{Error, ErrorKind};
pub use folder::{begun_now, fresh};
pub use jobs::{Program, run};
pub use merge::{MergeError, Merged, Sources};
pub use open_error::{FullError, OpenError, RESULTS};
pub use pace::{Pace, expected, shares, time_ns};
pub use points::run_points;
pub use process::Processes;
pub use progress::Progress;
pub use queue::{Clock, Queue, Turn};
pub use results::{Results, check_rows, check_whole};
pub use resume::pending;
pub use sweep_folder::SweepFolder;
pub use tries::{CellRun, Ended, run_cell};
pub use workers::simulate;
