//! All metrics of a cell's folder.

use std::io::ErrorKind;
use std::path::Path;

use column::Row;
use endpoint::{ArrivalRow, MessageRow, Mode, SecondRow, TickRow};
use plan::{ProbeRow, file_name};
use record::ReadError;
use record::order::{
    ArrivalOrder, Disorder, Gaps, MessageOrder, ProbeOrder, SecondOrder, TickOrder,
};
use record::rows::{Content, read, read_whole};
use record::whole::Vouched;
use serde::{Deserialize, Serialize};
use system::System;

use crate::arrival::{ArrivalCount, Arrivals};
use crate::asked::Asked;
use crate::message::{MessageCount, Messages};
use crate::probe::{ProbeCount, Probes};
use crate::response::{Aim, Response, ResponseTrace, SecondTrace};
use crate::silence::SilenceTrace;
use crate::tick::{TickCount, Ticks};
use crate::verdict::Finding;

/// What has to be known about a cell to read its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct CellFacts {
    /// Whether the loop was closed.
    pub mode: Mode,
    /// What its ticks are judged by.
    pub aim: Aim,
}

impl CellFacts {
    /// The facts of a cell with this system, whose first message was due at `start_ns`; where that is not known,
    /// its run begins with the first command.
    #[must_use]
    pub fn new(cell: &plan::Cell, system: &System, start_ns: Option<u64>) -> Self {
        let around = system.surroundings();
        let (noise, resolution) =
            around.map_or((0.0, 0.0), |around| (around.noise, around.resolution));
        let asked = |output| Asked::of(system.holding(), output, noise, resolution);
        Self {
            mode: cell.settings.mode,
            aim: Aim {
                h_ns: cell.settings.h.ns(),
                start_ns,
                duration_ns: Some(cell.duration_ns),
                r: cell.settings.r,
                reference: cell.moving_reference(),
                y0: system.plant_program().is_none().then_some(cell.y0),
                first: asked(0),
                second: asked(1),
                second_r: system.other_r().first().copied(),
            },
        }
    }
}

/// The facts of a cell of the paper's system whose run begins with its first command: for rows without a manifest.
impl From<&plan::Cell> for CellFacts {
    fn from(cell: &plan::Cell) -> Self {
        Self::new(cell, &System::paper(), None)
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
    /// The step response; `None` in open loop.
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
        let closed = facts.mode == Mode::Closed;
        let mut response = ResponseTrace::new(facts.aim.clone());
        let ticks = self.ticks(facts, &mut response);
        let second = if closed { response.second() } else { None };
        let second = second.and_then(|second| self.second(second));
        // Whose silence it was, the other rows tell.
        let mut silence = if closed { response.silence() } else { None };
        let arrivals = self.arrivals(facts, silence.as_mut());
        let messages = self.messages(silence.as_mut());
        let response = response.judged(silence.map(SilenceTrace::finish), second);
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

    /// Metrics of the ticks, which in closed loop are passed on to `response`.
    fn ticks(&mut self, facts: &CellFacts, response: &mut ResponseTrace) -> Ticks {
        let mut ticks = TickCount::new(facts.aim.h_ns);
        let mut order = TickOrder::new(facts.aim.h_ns, self.gaps(file_name::TICKS));
        let closed = facts.mode == Mode::Closed;
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
        ticks.finish()
    }

    /// Metrics of the arrivals, which tell `silence`, if there was one, what came.
    fn arrivals(&mut self, facts: &CellFacts, mut silence: Option<&mut SilenceTrace>) -> Arrivals {
        let mut arrivals = ArrivalCount::new(facts.aim.h_ns);
        let mut order = ArrivalOrder::default();
        let take = |row: &ArrivalRow| {
            arrivals.push(row);
            if let Some(silence) = &mut silence {
                silence.arrival(row);
            }
        };
        let rows = self.rows(
            file_name::ARRIVALS,
            ArrivalRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        self.judge(file_name::ARRIVALS, rows, Ok);
        arrivals.finish()
    }

    /// Metrics of the messages, which tell `silence`, if there was one, what was sent.
    fn messages(&mut self, mut silence: Option<&mut SilenceTrace>) -> Messages {
        let (mut messages, mut order) = (MessageCount::default(), MessageOrder::default());
        let take = |row: &MessageRow| {
            messages.push(row);
            if let Some(silence) = &mut silence {
                silence.message(row);
            }
        };
        let rows = self.rows(
            file_name::MESSAGES,
            MessageRow::COLUMNS,
            |row| order.check(row),
            take,
        );
        let gaps = self.gaps(file_name::MESSAGES);
        self.judge(file_name::MESSAGES, rows, |rows| {
            let whole = match gaps {
                Gaps::None => order.end(),
                Gaps::Allowed => Ok(()),
            };
            whole.map(|()| rows)
        });
        messages.finish()
    }

    /// A file may lack rows if it has those of an end that was killed as the experiment asked.
    fn gaps(&self, name: &str) -> Gaps {
        self.vouched
            .map_or(Gaps::None, |vouched| vouched.gaps(name))
    }

    /// The verdict on the second output; `None` if there is none.
    fn second(&mut self, mut trace: SecondTrace) -> Option<Finding> {
        let is_there = match self.vouched {
            Some(vouched) => vouched.files.contains_key(file_name::SECOND),
            None => self.folder.join(file_name::SECOND).exists(),
        };
        if !is_there {
            return None;
        }
        let mut order = SecondOrder::new(self.gaps(file_name::SECOND));
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
        mut check: impl FnMut(&R) -> Result<(), Disorder>,
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
            Ok::<_, Disorder>(())
        })
    }

    /// Records what is wrong with a file after it has been read. `end` takes the number of rows; it
    /// returns the number to compare with the reports, or what is wrong with the rows as a whole.
    fn judge(
        &mut self,
        name: &str,
        read: Result<Content, ReadError>,
        end: impl FnOnce(u64) -> Result<u64, Disorder>,
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
                let damaged = |disorder: Disorder| ReadError::Damaged {
                    path,
                    problem: disorder.to_string(),
                };
                self.faults.extend(counted.map_err(damaged).err());
            }
        }
    }
}
