//! What a trial saw of a controller: its messages at the plant, and its end.
//!
//! Times are in ns of `CLOCK_MONOTONIC`. `check` judges a record.

use endpoint::{Mode, Request};

/// A message that reached the plant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Arrival {
    pub(crate) t_ns: u64,
    /// Number of its connection.
    pub(crate) connection: u64,
    pub(crate) mode: Mode,
    pub(crate) request: Request,
    /// The output in its answer, if it got one.
    pub(crate) y: Option<f64>,
}

/// What a plant heard.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Heard {
    /// Number of connections.
    pub(crate) connections: u64,
    /// All messages, in the order of their arrival.
    pub(crate) arrivals: Vec<Arrival>,
    /// Number of requests that any plant refuses.
    pub(crate) refused: u64,
    /// Why the first of them was refused.
    pub(crate) first_refused: Option<String>,
    /// When the plant closed a connection by its script.
    pub(crate) closed_ns: Vec<u64>,
}

/// How a controller ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Ending {
    /// When it had ended; `None` if it still ran when the trial was over.
    pub(crate) ended_ns: Option<u64>,
    /// When the trial sent it SIGTERM, if it did.
    pub(crate) told_ns: Option<u64>,
    /// What was wrong with its end.
    pub(crate) problem: Option<String>,
    /// Whether it ended with exit code 127.
    pub(crate) is_unsupported: bool,
    /// Whether it had to be killed.
    pub(crate) is_killed: bool,
}

/// Everything that a trial saw of one controller.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Record {
    /// When its first message was due.
    pub(crate) start_ns: u64,
    pub(crate) heard: Heard,
    pub(crate) ending: Ending,
}

impl Heard {
    /// Counts a request that any plant refuses.
    pub(crate) fn refuse(&mut self, why: &str) {
        self.refused += 1;
        self.first_refused.get_or_insert_with(|| why.to_owned());
    }

    /// Counts a connection; its number.
    pub(crate) fn connect(&mut self) -> u64 {
        self.connections += 1;
        self.connections
    }

    /// Number of messages.
    pub(crate) fn messages(&self) -> u64 {
        self.arrivals.len() as u64
    }
}
