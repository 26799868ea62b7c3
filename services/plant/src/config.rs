//! Settings of a plant beside its model, and why it may fail. [`endpoint::report::Plant`] is its report.

use std::{io, net::SocketAddr, path::PathBuf};

use clock::journal::JournalError;
use endpoint::{PlantSettings, Reference};
use serde::{Deserialize, Serialize};

/// Settings of a plant beside the model that it steps.
#[derive(Clone, Debug)]
pub struct Config {
    /// The address to listen on; port 0 takes a free port, which [`Ready`] gives.
    pub listen: SocketAddr,
    /// The names under which clients know it, besides addresses, `localhost` and the name of the machine.
    pub hosts: Vec<String>,
    /// Sample time, treatment of late commands, watchdog, lease.
    pub settings: PlantSettings,
    /// The law that a page should follow, as `system` writes it; if `None`, the paper's.
    pub law: Option<serde_json::Value>,
    /// The reference that a page should follow, if it moves.
    pub reference: Option<Reference>,
    /// The folder of `ticks.csv`, `arrivals.csv` and, with a second input or output, `second.csv`, and of each page's `messages.csv` and
    /// `page.json`; created if necessary.
    pub out: PathBuf,
    /// Whether an earlier plant of the same run was killed: its ticks and arrivals are counted on, on the same
    /// grid, and its files appended to. The model and the sessions begin anew.
    pub again: bool,
}

/// What a plant reports when it can be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// The address on which it listens.
    pub address: SocketAddr,
    /// When tick 0 is due, on the run's clock; in the past if it goes on with an earlier plant's.
    pub start_ns: u64,
}

/// Why a plant did not run, or stopped early.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The plant cannot listen on the address.
    #[error("cannot listen on {address}: {source}; give a free address of this machine, or port 0")]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// The system's error.
        source: io::Error,
    },
    /// Rows are missing.
    #[error(transparent)]
    Rows(#[from] JournalError),
    /// The ticks to go on with are still to come.
    #[error(
        "cannot go on with {path}: its last tick was due at {t_due_ns} ns, and now it is {now_ns} ns; its rows \
         are from before the machine was started, so give another folder, or run without `again`"
    )]
    Ahead {
        /// The file of the ticks.
        path: PathBuf,
        /// When its last tick was due.
        t_due_ns: u64,
        /// The time now.
        now_ns: u64,
    },
    /// The system refused a thread, a timer or a signal handler.
    #[error("cannot start the plant: {0}")]
    Start(#[from] io::Error),
    /// The thread that steps the model ended by itself, or the model broke.
    #[error("the plant's tick thread ended too early, and so do its rows")]
    Ticker,
}
