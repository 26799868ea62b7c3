//! What a controller is told, what it tells, and why it may fail.

use std::{io, path::PathBuf};

use control::Law;
use endpoint::{ControllerSettings, Counts, InvalidSettings};
use journal::{JournalError, Written};
use pace::Scheduling;
use serde::{Deserialize, Serialize};

/// Everything that a controller is told.
#[derive(Clone, Debug)]
pub struct Config {
    /// The plant, as `http://10.77.0.2:8080`.
    pub plant: String,
    /// How it sends.
    pub settings: ControllerSettings,
    /// The control law at rest, such as `control::preset::paper_pi()`.
    pub law: Law,
    /// The first deadline on the run's clock; soon, if not given.
    pub start_ns: Option<u64>,
    /// Deadlines end this long after the first.
    pub duration_ns: u64,
    /// Connections opened before the start, at least one; a WebSocket is always
    /// one. Over HTTP requests at one time each need their own: a client that
    /// sends more opens the others as it goes, each for a round trip.
    pub connections: u16,
    /// The folder of `messages.csv`; made if need be.
    pub out: PathBuf,
    /// Whether to ask for real-time scheduling.
    pub fifo: bool,
}

/// What a controller tells when it has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// The first deadline, on the run's clock.
    pub start_ns: u64,
    /// Where the deadlines ended.
    pub stop_ns: u64,
    /// What became of the deadlines.
    pub counts: Counts,
    /// Why the first message failed that did.
    pub first_failure: Option<String>,
    /// Whether it was told to end before its time. Messages under way then
    /// count as failed.
    pub interrupted: bool,
    /// Rows of `messages.csv`.
    pub rows: Written,
    /// What the kernel granted.
    pub granted: Granted,
}

/// What the kernel granted to the controller.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Granted {
    /// To its thread.
    pub controller: Scheduling,
    /// Files and sockets that may be open.
    pub open_files: u64,
}

/// Why a controller did not run, or not to its end.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// The plant's address is not one.
    #[error("plant `{plant}`: {why}; write it like http://10.77.0.2:8080")]
    Address {
        /// What was asked.
        plant: String,
        /// What is wrong with it.
        why: String,
    },
    /// The settings make no controller.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
    /// No client can follow the settings.
    #[error("{0}")]
    Conflict(&'static str),
    /// No answer before the start.
    #[error(
        "no plant answers at {plant} after {waited_s} s: {why}; is it started, and is this its address?"
    )]
    Unreachable {
        /// What was asked.
        plant: String,
        /// How long it was waited for.
        waited_s: u64,
        /// What the last attempt came to.
        why: String,
    },
    /// Rows are missing.
    #[error(transparent)]
    Rows(#[from] JournalError),
    /// The system refused a timer, a thread or a signal handler.
    #[error("cannot run the controller: {0}")]
    System(#[from] io::Error),
}
