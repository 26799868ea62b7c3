//! A campaign: its results folder, and the running of its cells; likewise a sweep's.
//!
//! - `folder`: a folder that one process writes to; [`CampaignFolder`] and [`SweepFolder`] say what
//!   is in it, [`Findings`] what is made of a sweep's rows.
//! - [`pending`]: what is left to do in a folder that is gone on with; [`Own`]: whether what is
//!   there is of this run's kind.
//! - [`Queue`]: whose turn it is; [`run`]: the cells of a queue, each by a [`Program`], which is a
//!   process ([`Processes`]) but in tests. [`run_cell`]: what such a process does for its cell,
//!   again while it is disturbed.
//! - [`ComposeRunner`]: the cells in containers; [`attach`]: the agents in there.
//! - [`Pace`]: how long all of it will take; [`threads`]: a sweep's runs.
//! - [`Sources`]: folders of one plan merged; [`Results`]: a folder's table; [`series`]: its rows in
//!   one CSV; [`calibration`]: what they say of a machine.
//!
//! Arguments, words for people on how it goes and exit codes are the binary's: it is told of
//! [`Progress`], and hands in the program of a cell and the clock.
#![forbid(unsafe_code)]

pub mod attach;
pub mod calibration;
mod campaign_folder;
mod containers;
mod earlier;
mod error;
mod findings;
mod folder;
mod jobs;
mod merge;
mod open_error;
pub mod owner;
mod pace;
mod process;
mod progress;
mod queue;
mod results;
mod resume;
#[cfg(test)]
mod sample;
pub mod series;
mod sweep_folder;
pub mod threads;
mod tries;

pub use campaign_folder::CampaignFolder;
pub use containers::{ComposeRunner, Inside};
pub use earlier::Own;
pub use error::{Error, Kind};
pub use findings::Findings;
pub use folder::fresh;
pub use jobs::{Program, Running, run};
pub use merge::{MergeError, Merged, Sources};
pub use open_error::{FullError, OpenError, RESULTS};
pub use pace::{Pace, expected, shares, time_ns};
pub use process::Processes;
pub use progress::Progress;
pub use queue::{Clock, Queue, Turn};
pub use results::{Results, check_whole};
pub use resume::pending;
pub use sweep_folder::SweepFolder;
pub use tries::{CellRun, Ended, run_cell};
