//! Settings of a plant, and why it may fail. What it reports at its end is
//! [`endpoint::report::Plant`].

use std::{io, net::SocketAddr, path::PathBuf};

use control::{InvalidDiscretisation, Plant};
use endpoint::PlantSettings;
use journal::JournalError;
use serde::{Deserialize, Serialize};

/// Settings of a plant.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where it listens; port 0 takes a free one, which [`Ready`] names.
    pub listen: SocketAddr,
    /// Sample time, what becomes of late commands, and how long a command is held.
    pub settings: PlantSettings,
    /// The plant, such as `control::preset::paper_plant()`.
    pub plant: Plant,
    /// The law that a page is to follow, as `system` writes it; the paper's, if none is given.
    pub law: Option<serde_json::Value>,
    /// The folder of `ticks.csv` and `arrivals.csv`, and of each page's
    /// `messages.csv` and `page.json`; made if need be.
    pub out: PathBuf,
    /// Whether to ask for real-time scheduling.
    pub fifo: bool,
}

/// What a plant tells when it can be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// Where it listens.
    pub address: SocketAddr,
    /// When tick 0 is due, on the run's clock.
    pub start_ns: u64,
}

/// Why a plant did not run, or not to its end.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; give a free address of this machine, or port 0")]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
    /// The model cannot be sampled at this h.
    #[error("cannot sample the plant's model: {0}")]
    Model(#[from] InvalidDiscretisation),
    /// Rows are missing.
    #[error(transparent)]
    Rows(#[from] JournalError),
    /// The system refused a thread, a timer or a signal handler.
    #[error("cannot start the plant: {0}")]
    Start(#[from] io::Error),
    /// The thread that steps the model ended by itself.
    #[error("the plant's tick thread ended too early, and so do its rows")]
    Ticker,
}
