//! All metrics of a cell's folder.

use std::io::ErrorKind;
use std::path::Path;

use endpoint::{ArrivalRow, MessageRow, Mode, Reference, SecondRow, TickRow};
use serde::{Deserialize, Serialize};

use crate::arrival::{ArrivalCount, Arrivals};
use crate::message::{MessageCount, Messages};
use crate::order::{ArrivalOrder, MessageOrder, ProbeOrder, SecondOrder, TickOrder};
use crate::plain::Row;
use crate::probe::{ProbeCount, Probes};
use crate::response::{LoopVerdict, Response, ResponseTrace, SecondTrace};
use crate::rows::{Content, ReadError, read, read_whole};
use crate::tick::{TickCount, Ticks};
use crate::whole::Vouched;
use plan::{ProbeRow, file_name};

/// What has to be known about a cell to read its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct CellFacts {
    /// The sample time, ns.
    pub h_ns: u64,
    /// Whether the loop was closed.
    pub mode: Mode,
    /// The reference; at the start, if it moves.
    pub r: f64,
    /// The output at the loop's start; 0 at rest.
    pub y0: f64,
    /// The changes of a reference that moves.
    pub reference: Option<Reference>,
}

impl From<&plan::Cell> for CellFacts {
    fn from(cell: &plan::Cell) -> Self {
        Self {
            h_ns: cell.settings.h.ns(),
            mode: cell.settings.mode,
            r: cell.settings.r,
            y0: cell.y0,
            reference: cell.moving_reference(),
        }
    }
}

/// The metrics of a cell, from the four files of its folder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Echoes through the link; `None` if the run ended before it wrote them.
    pub probes: Option<Probes>,
    /// The controller's messages.
    pub messages: Messages,
    /// The messages that arrived.
    pub arrivals: Arrivals,
    /// The plant's ticks.
    pub ticks: Ticks,
    /// The step response; `None` in open loop, or if no command arrived.
    pub response: Option<Response>,
    /// Number of files whose last line was torn and dropped.
    pub torn_lines: u64,
}

impl Metrics {
    /// Reads `ticks.csv`, `arrivals.csv`, `messages.csv` and `probes.csv` of a folder, each once,
    /// without checking them against a manifest: for instance, what a killed run left.
    ///
    /// # Errors
    /// [`ReadError`] if one of the first three is missing, or one of the four holds something other
    /// than its rows.
    pub fn read(folder: &Path, facts: &CellFacts) -> Result<Metrics, ReadError> {
        Reader {
            folder,
            vouched: None,
            torn_lines: 0,
            faults: Vec::new(),
        }
        .metrics(facts)
        .map_err(|mut faults| faults.swap_remove(0))
    }

    /// Reads the same four files, and checks that they are whole and as `vouched` says.
    ///
    /// # Errors
    /// The first fault of each of the four files.
    pub(crate) fn read_whole(
        folder: &Path,
        facts: &CellFacts,
        vouched: &Vouched<'_>,
    ) -> Result<Metrics, Vec<ReadError>> {
        Reader {
            folder,
            vouched: Some(vouched),
            torn_lines: 0,
            faults: Vec::new(),
        }
        .metrics(facts)
    }
}

/// Reads the four files one after the other.
struct Reader<'a> {
    folder: &'a Path,
    /// What the files are checked against; `None` for no check.
    vouched: Option<&'a Vouched<'a>>,
    torn_lines: u64,
    /// Faults found so far; not empty if a file could not be read.
    faults: Vec<ReadError>,
}

impl Reader<'_> {
    fn metrics(mut self, facts: &CellFacts) -> Result<Metrics, Vec<ReadError>> {
        let mut ticks = TickCount::new(facts.h_ns);
        let mut response =
            ResponseTrace::new(facts.h_ns, facts.r, facts.reference.clone()).from_output(facts.y0);
        let closed = facts.mode == Mode::Closed;
        let mut order = TickOrder::new(facts.h_ns, self.may_lack(file_name::TICKS));
        let take = |row: &TickRow| {
            ticks.push(row);
            if closed {
                response.push(row);
            }
        };
        let rows = self.rows(
            file_name::TICKS,
            TickRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        self.judge(file_name::TICKS, rows, Ok);
        let second = if closed { response.second() } else { None };
        let second = second.and_then(|second| self.second(second));
        // Finished before the next file is read, so that only one file's values are in memory at a
        // time.
        let (ticks, mut response) = (ticks.finish(), response.finish());
        if let (Some(response), Some(second)) = (&mut response, second) {
            response.verdict = response.verdict.max(second);
        }

        let (mut arrivals, mut order) = (ArrivalCount::new(facts.h_ns), ArrivalOrder::default());
        let take = |row: &ArrivalRow| arrivals.push(row);
        let rows = self.rows(
            file_name::ARRIVALS,
            ArrivalRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        self.judge(file_name::ARRIVALS, rows, Ok);
        let arrivals = arrivals.finish();

        let (mut messages, mut order) = (MessageCount::default(), MessageOrder::default());
        let take = |row: &MessageRow| messages.push(row);
        let rows = self.rows(
            file_name::MESSAGES,
            MessageRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        let may_lack = self.may_lack(file_name::MESSAGES);
        self.judge(file_name::MESSAGES, rows, |rows| {
            let whole = if may_lack { Ok(()) } else { order.end() };
            whole.map(|()| rows)
        });
        let messages = messages.finish();

        let probes = self.probes();
        if self.faults.is_empty() {
            Ok(Metrics {
                probes,
                messages,
                arrivals,
                ticks,
                response,
                torn_lines: self.torn_lines,
            })
        } else {
            Err(self.faults)
        }
    }

    /// Whether the file has the rows of an end that was killed as the experiment asked.
    fn may_lack(&self, name: &str) -> bool {
        self.vouched.is_some_and(|vouched| vouched.may_lack(name))
    }

    /// The verdict on the second output; `None` if there is none.
    fn second(&mut self, mut trace: SecondTrace) -> Option<LoopVerdict> {
        let is_there = match self.vouched {
            Some(vouched) => vouched.files.contains_key(file_name::SECOND),
            None => self.folder.join(file_name::SECOND).exists(),
        };
        if !is_there {
            return None;
        }
        let mut order = SecondOrder::new(self.may_lack(file_name::SECOND));
        let rows = self.rows(
            file_name::SECOND,
            SecondRow::COLUMNS,
            |row| order.check(row),
            |row: &SecondRow| trace.push(row),
        );
        self.judge(file_name::SECOND, rows, Ok);
        trace.finish()
    }

    /// Metrics of the echoes; `None` if the folder is not checked and has no `probes.csv`.
    fn probes(&mut self) -> Option<Probes> {
        let (mut probes, mut order) = (ProbeCount::default(), ProbeOrder::default());
        let take = |row: &ProbeRow| probes.push(row);
        let rows = self.rows(
            file_name::PROBES,
            ProbeRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        match rows {
            Err(ReadError::File { source, .. })
                if self.vouched.is_none() && source.kind() == ErrorKind::NotFound =>
            {
                None
            }
            rows => {
                self.judge(file_name::PROBES, rows, |_| Ok(order.through));
                Some(probes.finish())
            }
        }
    }

    /// Passes the rows of a file to `take`; if the file is checked, after `check` has accepted them.
    fn rows<R: Row>(
        &self,
        name: &str,
        columns: &[&str],
        mut check: impl FnMut(&R) -> Result<(), String>,
        mut take: impl FnMut(&R),
    ) -> Result<Content, ReadError> {
        let path = self.folder.join(name);
        let Some(vouched) = self.vouched else {
            return read(&path, columns, take).map(|torn| Content { rows: 0, torn });
        };
        let Some(fact) = vouched.files.get(name) else {
            let problem = "its manifest does not list it".to_owned();
            return Err(ReadError::Damaged { path, problem });
        };
        read_whole(&path, columns, fact, |row| {
            if !vouched.has_gaps {
                check(row)?;
            }
            take(row);
            Ok(())
        })
    }

    /// Records what is wrong with a file after it has been read. `end` takes the number of rows; it
    /// returns the number to compare with the reports, or what is wrong with the rows as a whole.
    fn judge(
        &mut self,
        name: &str,
        read: Result<Content, ReadError>,
        end: impl FnOnce(u64) -> Result<u64, String>,
    ) {
        let path = self.folder.join(name);
        match read {
            Err(fault) => self.faults.push(fault),
            Ok(Content { rows, torn }) => {
                self.torn_lines += u64::from(torn);
                let Some(vouched) = self.vouched else { return };
                let counted = if vouched.has_gaps {
                    Ok(())
                } else {
                    end(rows).and_then(|count| vouched.count(name, count))
                };
                let damaged = |problem| ReadError::Damaged { path, problem };
                self.faults.extend(counted.map_err(damaged).err());
            }
        }
    }
}
