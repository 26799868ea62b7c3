//! Everything that is measured in a cell's folder.

use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, Mode, TickRow};
use serde::{Deserialize, Serialize};

use crate::arrival::{ArrivalCount, Arrivals};
use crate::message::{MessageCount, Messages};
use crate::probe::{ProbeCount, Probes};
use crate::response::{Response, ResponseTrace};
use crate::rows::{ReadError, read};
use crate::tick::{TickCount, Ticks};
use plan::ProbeRow;

/// What has to be known of a cell to read its rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellFacts {
    /// The sample time, ns.
    pub h_ns: u64,
    /// Whether the loop was closed.
    pub mode: Mode,
    /// The reference.
    pub r: f64,
}

impl From<&plan::Cell> for CellFacts {
    fn from(cell: &plan::Cell) -> Self {
        Self {
            h_ns: cell.settings.h.ns(),
            mode: cell.settings.mode,
            r: cell.settings.r,
        }
    }
}

/// The metrics of a cell, from the four files of its folder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Echoes through the link; `None` where the run ended before it wrote them.
    pub probes: Option<Probes>,
    /// The controller's messages.
    pub messages: Messages,
    /// The messages that arrived.
    pub arrivals: Arrivals,
    /// The plant's ticks.
    pub ticks: Ticks,
    /// The step response; `None` in open loop, and where no command came.
    pub response: Option<Response>,
    /// Files whose last line was torn and dropped.
    pub torn_lines: u64,
}

impl Metrics {
    /// Reads `ticks.csv`, `arrivals.csv`, `messages.csv` and `probes.csv` of a folder, each once.
    ///
    /// # Errors
    /// [`ReadError`] when one of the first three is missing, or one of the four holds something
    /// other than its rows.
    pub fn read(folder: &Path, facts: &CellFacts) -> Result<Metrics, ReadError> {
        let mut torn_lines = 0;

        let mut ticks = TickCount::new(facts.h_ns);
        let mut response = ResponseTrace::new(facts.h_ns, facts.r);
        let closed = facts.mode == Mode::Closed;
        torn_lines += u64::from(read(
            &folder.join("ticks.csv"),
            TickRow::COLUMNS,
            |row: &TickRow| {
                ticks.push(row);
                if closed {
                    response.push(row);
                }
            },
        )?);
        // Before the next file is read: only one file's values are kept at a time.
        let (ticks, response) = (ticks.finish(), response.finish());

        let mut arrivals = ArrivalCount::new(facts.h_ns);
        let path = folder.join("arrivals.csv");
        torn_lines += u64::from(read(&path, ArrivalRow::COLUMNS, |row| arrivals.push(row))?);
        let arrivals = arrivals.finish();

        let mut messages = MessageCount::default();
        let path = folder.join("messages.csv");
        torn_lines += u64::from(read(&path, MessageRow::COLUMNS, |row| messages.push(row))?);
        let messages = messages.finish();

        let mut probes = ProbeCount::default();
        let path = folder.join("probes.csv");
        let probes = match read(&path, ProbeRow::COLUMNS, |row| probes.push(row)) {
            Ok(torn) => {
                torn_lines += u64::from(torn);
                Some(probes.finish())
            }
            Err(ReadError::File { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                None
            }
            Err(error) => return Err(error),
        };

        Ok(Metrics {
            probes,
            messages,
            arrivals,
            ticks,
            response,
            torn_lines,
        })
    }
}
