//! Settings of a controller, and why it may fail. [`endpoint::report::Native`] is its report.

use std::{io, path::PathBuf};

use clock::journal::JournalError;
use control::Law;
use endpoint::{ControllerSettings, InvalidSetting, InvalidSettings, Policy, Reference};

/// Settings of a controller.
#[derive(Clone, Debug)]
pub struct Config {
    /// The plant, as `http://10.77.0.2:8080`.
    pub plant: String,
    /// How the controller sends.
    pub settings: ControllerSettings,
    /// Whether to claim the plant for a session first, and again after losing it.
    pub claim: bool,
    /// Whether commands have a checksum, and answers need one.
    pub check: bool,
    /// The reference, if it moves.
    pub reference: Option<Reference>,
    /// The control law at rest, such as `control::preset::paper_pi()`.
    pub law: Law,
    /// The first deadline on the run's clock; if not given, soon after the warm-up.
    pub start_ns: Option<u64>,
    /// Whether an earlier controller of the same run, with the same `start_ns`, was killed: this one counts its
    /// deadlines on, and appends to its file.
    pub again: bool,
    /// Time from the first deadline to the end of the deadlines.
    pub duration_ns: u64,
    /// Connections opened before the start, at least one; a WebSocket always has one. Over HTTP each
    /// simultaneous request needs its own: a client that sends more of them opens the others during
    /// the run, each for a round trip.
    pub connections: u16,
    /// The folder of `messages.csv`; created if necessary.
    pub out: PathBuf,
    /// What its thread asks the kernel for.
    pub scheduling: Policy,
}

/// Why a controller did not run, or did not complete its run.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// The plant's address is invalid.
    #[error("plant `{plant}`: {why}; write it like http://10.77.0.2:8080")]
    Address {
        /// The address that was given.
        plant: String,
        /// What is wrong with the address.
        why: String,
    },
    /// The controller's end rejects the settings.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
    /// No client can follow the settings.
    #[error(transparent)]
    Conflict(#[from] InvalidSetting),
    /// The plant did not answer before the start.
    #[error(
        "no plant answers at {plant} after {waited_s} s: {why}; start it, or correct the address"
    )]
    Unreachable {
        /// The address of the plant.
        plant: String,
        /// How long it was waited for.
        waited_s: u64,
        /// The result of the last attempt.
        why: String,
    },
    /// Rows are missing.
    #[error(transparent)]
    Rows(#[from] JournalError),
    /// The system refused a timer, a thread or a signal handler.
    #[error("cannot run the controller: {0}")]
    System(#[from] io::Error),
}
