//! All metrics of a cell's folder.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use endpoint::{ArrivalRow, MessageRow, Mode, SecondRow, TickRow};
use plan::system::System;
use plan::{ProbeRow, file_name};
use record::order::{
    ArrivalOrder, Disorder, Gaps, MessageOrder, ProbeOrder, SecondOrder, TickOrder,
};
use record::rows::{Content, read, read_whole};
use record::whole::Vouched;
use record::{Held, ReadError};
use serde::{Deserialize, Serialize};
use text::column::Row;

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
        Reader::of(Source::Folder(folder))
            .metrics(facts)
            .map_err(|mut faults| faults.swap_remove(0))
    }

    /// The metrics of rows that are in memory, by the code that reads them from files. Nothing is checked: they are
    /// those of a run that this process has just made.
    #[must_use]
    pub fn of(rows: &Held, facts: &CellFacts) -> Option<Metrics> {
        Reader::of(Source::Held(rows)).metrics(facts).ok()
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
        Reader::of(Source::Whole(folder, vouched)).metrics(facts)
    }
}

/// Where rows are.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// In files that nothing vouches for.
    Folder(&'a Path),
    /// In files that have to be whole.
    Whole(&'a Path, &'a Vouched<'a>),
    /// In memory.
    Held(&'a Held),
}

impl<'a> Source<'a> {
    /// What the files are checked against; `None` for no check.
    fn vouched(self) -> Option<&'a Vouched<'a>> {
        match self {
            Source::Whole(_, vouched) => Some(vouched),
            Source::Folder(_) | Source::Held(_) => None,
        }
    }

    /// Whether there is a second input or output.
    fn has_second(self) -> bool {
        match self {
            Source::Folder(folder) => folder.join(file_name::SECOND).exists(),
            Source::Whole(_, vouched) => vouched.files.contains_key(file_name::SECOND),
            Source::Held(rows) => rows.second.is_some(),
        }
    }

    /// The path of a file; of rows in memory, its name.
    fn path(self, name: &str) -> PathBuf {
        match self {
            Source::Folder(folder) | Source::Whole(folder, _) => folder.join(name),
            Source::Held(_) => PathBuf::from(name),
        }
    }
}

/// Reads the four files one after the other.
struct Reader<'a> {
    source: Source<'a>,
    torn_lines: u64,
    /// Faults found so far; not empty if a file could not be read.
    faults: Vec<ReadError>,
}

impl<'a> Reader<'a> {
    fn of(source: Source<'a>) -> Reader<'a> {
        Reader {
            source,
            torn_lines: 0,
            faults: Vec::new(),
        }
    }

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
            |held| &held.ticks,
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
            |held| &held.arrivals,
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
            |held| &held.messages,
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
        let vouched = self.source.vouched();
        vouched.map_or(Gaps::None, |vouched| vouched.gaps(name))
    }

    /// The verdict on the second output; `None` if there is none.
    fn second(&mut self, mut trace: SecondTrace) -> Option<Finding> {
        if !self.source.has_second() {
            return None;
        }
        let mut order = SecondOrder::new(self.gaps(file_name::SECOND));
        let rows = self.rows(
            file_name::SECOND,
            |held| held.second.as_deref().unwrap_or_default(),
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
            |held| &held.probes,
            |row| order.check(row),
            take,
        );
        match rows {
            Err(ReadError::File { source, .. })
                if self.source.vouched().is_none() && source.kind() == ErrorKind::NotFound =>
            {
                None
            }
            rows => {
                self.judge(file_name::PROBES, rows, |_| Ok(order.through));
                Some(probes.finish())
            }
        }
    }

    /// Passes the rows of a file to `take`; if the file is checked, after `check` has accepted them. In memory its rows
    /// are where `held` says.
    fn rows<R: Row>(
        &self,
        name: &str,
        held: impl Fn(&Held) -> &[R],
        mut check: impl FnMut(&R) -> Result<(), Disorder>,
        mut take: impl FnMut(&R),
    ) -> Result<Content, ReadError> {
        let path = self.source.path(name);
        let vouched = match self.source {
            Source::Held(rows) => {
                held(rows).iter().for_each(take);
                return Ok(Content {
                    rows: 0,
                    torn: false,
                });
            }
            Source::Folder(_) => {
                return read(&path, take).map(|torn| Content { rows: 0, torn });
            }
            Source::Whole(_, vouched) => vouched,
        };
        let Some(fact) = vouched.files.get(name) else {
            let problem = "its manifest does not list it".to_owned();
            return Err(ReadError::Damaged { path, problem });
        };
        read_whole(&path, fact, |row| {
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
        let path = self.source.path(name);
        match read {
            Err(fault) => self.faults.push(fault),
            Ok(Content { rows, torn }) => {
                self.torn_lines += u64::from(torn);
                let Some(vouched) = self.source.vouched() else {
                    return;
                };
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
