//! Settings of a controller, and why it may fail. What it reports at its end is
//! [`endpoint::report::Native`].

use std::{io, path::PathBuf};

use control::Law;
use endpoint::{ControllerSettings, InvalidSetting, InvalidSettings};
use journal::JournalError;

/// Settings of a controller.
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

/// Why a controller did not run, or not to its end.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// The plant's address is not one.
    #[error("plant `{plant}`: {why}; write it like http://10.77.0.2:8080")]
    Address {
        /// What was asked.
        plant: String,
        /// The fault in the address.
        why: String,
    },
    /// The settings make no controller.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
    /// No client can follow the settings.
    #[error(transparent)]
    Conflict(#[from] InvalidSetting),
    /// No answer before the start.
    #[error(
        "no plant answers at {plant} after {waited_s} s: {why}; start it, or correct the address"
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
