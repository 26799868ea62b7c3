//! A plant of somebody's own: a program that advances by h for each u that it reads, and prints y.
//!
//! Its standard input and output are one socket, a line a number, or two with a comma between them: first it
//! prints the y that it starts with, then one y after each u. It ends when its input does.
//! docs/your-plant.md is its contract. What time a step has is the caller's matter; here a step that takes too
//! long breaks it.

mod problem;
pub(crate) mod start;

use std::fmt::Write as _;
use std::io::{ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use endpoint::{Model, Signals, report};

use crate::keeper::{END_WITHIN, Keeper};

pub use problem::{BrokenPlant, Due, PlantProblem};
pub use start::{Confinement, Start};

/// Longest line that it may print, bytes.
const LINE_BYTES: usize = 4096;

/// A running program. Clones are the same program; it ends with the last of them.
#[derive(Debug, Clone)]
pub struct PlantProgram {
    steps: Arc<Mutex<Steps>>,
    /// The outputs before the first step.
    at_rest: Signals,
    inputs: usize,
}

impl PlantProgram {
    /// Starts a program, and waits for its first y. What it prints on standard error goes to this process's,
    /// up to 1 MiB.
    ///
    /// # Errors
    /// [`BrokenPlant`] if it cannot be started, or does something else than to print a number.
    pub fn start(start: &Start<'_>) -> Result<PlantProgram, BrokenPlant> {
        let name = start.run.join(" ");
        let fail = |reason| BrokenPlant {
            program: name.clone(),
            problem: PlantProblem::Start { reason },
        };
        let (stream, theirs) = UnixStream::pair().map_err(fail)?;
        let keeper = Keeper::start(start, theirs).map_err(fail)?;
        let mut steps = Steps {
            name,
            stream,
            unread: Vec::new(),
            keeper,
            step_within: start.step_within,
            problem: None,
            report: report::PlantProgram {
                run: start.run.to_vec(),
                steps: 0,
                slow: 0,
                slowest_ns: 0,
            },
            h_ns: start.h_ns,
            outputs: None,
            is_infinite: false,
        };
        let at_rest = steps
            .answer(Due::First, start.start_within)
            .map_err(|problem| BrokenPlant {
                program: start.run.join(" "),
                problem,
            })?;
        Ok(PlantProgram {
            steps: Arc::new(Mutex::new(steps)),
            at_rest,
            inputs: start.inputs,
        })
    }

    /// Why it steps no more, as a sentence; `None` if it does.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let steps = self.lock();
        steps.problem.as_ref().map(ToString::to_string)
    }

    /// Ends its input and waits for its end. Returns its exit code, as a shell has it; `None` if it still ran
    /// after 1 s, and so was killed.
    #[must_use]
    pub fn end(self) -> Option<i32> {
        let steps = self.lock();
        let _ = steps.stream.shutdown(Shutdown::Write);
        steps.keeper.code_within(END_WITHIN)
    }

    /// What became of its steps so far.
    #[must_use]
    pub fn report(&self) -> report::PlantProgram {
        self.lock().report.clone()
    }

    fn lock(&self) -> MutexGuard<'_, Steps> {
        self.steps.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Model for PlantProgram {
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        self.lock().step(u)
    }

    fn at_rest(&self) -> Signals {
        self.at_rest
    }

    fn inputs(&self) -> usize {
        self.inputs
    }

    fn is_broken(&self) -> bool {
        self.lock().problem.is_some()
    }
}

/// The exchange of u and y with a program.
#[derive(Debug)]
struct Steps {
    /// Its command, for sentences about it.
    name: String,
    stream: UnixStream,
    /// What it printed after the last line that was taken.
    unread: Vec<u8>,
    /// Ends the program when this is dropped, after the stream.
    keeper: Keeper,
    step_within: Duration,
    problem: Option<BrokenPlant>,
    report: report::PlantProgram,
    h_ns: u64,
    /// How many numbers its first line had.
    outputs: Option<usize>,
    /// Whether it has printed a number that is not finite.
    is_infinite: bool,
}

impl Steps {
    fn step(&mut self, u: Signals) -> Signals {
        if self.problem.is_some() {
            return f64::NAN.into();
        }
        let begun = Instant::now();
        match self.exchange(u) {
            Ok(y) => {
                let took_ns = u64::try_from(begun.elapsed().as_nanos()).unwrap_or(u64::MAX);
                let report = &mut self.report;
                report.steps += 1;
                report.slow += u64::from(took_ns > self.h_ns);
                report.slowest_ns = report.slowest_ns.max(took_ns);
                y
            }
            Err(problem) => {
                self.problem = Some(BrokenPlant {
                    program: self.name.clone(),
                    problem,
                });
                f64::NAN.into()
            }
        }
    }

    fn exchange(&mut self, u: Signals) -> Result<Signals, PlantProblem> {
        let step = self.report.steps;
        if !self.unread.is_empty() {
            let printed = shown(&self.unread);
            return Err(PlantProblem::Early { printed, step });
        }
        let mut line = String::with_capacity(32);
        let _ = writeln!(line, "{u}");
        let due = Due::Step(step);
        match self.stream.write_all(line.as_bytes()) {
            Ok(()) => self.answer(due, self.step_within),
            Err(_) => Err(self.ended(due)),
        }
    }

    /// The next line that it prints, as numbers.
    fn answer(&mut self, due: Due, within: Duration) -> Result<Signals, PlantProblem> {
        let line = self.line(due, within)?;
        let text = String::from_utf8_lossy(&line);
        let no_number = || PlantProblem::NoNumber {
            printed: shown(&line),
            due,
        };
        let y: Signals = text.trim().parse().map_err(|_| no_number())?;
        // What overflows is infinite, and then anything: a loop that was lost. NaN before is a mistake of the program.
        let is_nan = y.iter().any(f64::is_nan);
        if is_nan && !self.is_infinite {
            return Err(no_number());
        }
        self.is_infinite |= !y.is_finite();
        match self.outputs {
            Some(first) if first != y.count() => Err(PlantProblem::OtherCount {
                printed: shown(&line),
                due,
                first,
            }),
            _ => {
                self.outputs = Some(y.count());
                Ok(y)
            }
        }
    }

    fn line(&mut self, due: Due, within: Duration) -> Result<Vec<u8>, PlantProblem> {
        let late = PlantProblem::Late { due, within };
        let deadline = Instant::now() + within;
        let mut part = [0; 512];
        loop {
            if let Some(end) = self.unread.iter().position(|byte| *byte == b'\n') {
                return Ok(self.unread.drain(..=end).collect());
            }
            if self.unread.len() > LINE_BYTES {
                return Err(PlantProblem::Long { due });
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || self.stream.set_read_timeout(Some(left)).is_err() {
                return Err(late);
            }
            match self.stream.read(&mut part) {
                Ok(0) => return Err(self.ended(due)),
                Ok(length) => self.unread.extend_from_slice(&part[..length]),
                Err(problem) => match problem.kind() {
                    ErrorKind::Interrupted => {}
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => return Err(late),
                    _ => return Err(self.ended(due)),
                },
            }
        }
    }

    /// Why there is no answer from a program whose end of the socket is closed.
    fn ended(&self, due: Due) -> PlantProblem {
        match self.keeper.code_within(END_WITHIN) {
            None => PlantProblem::Closed(due),
            Some(code) => PlantProblem::Ended { code, due },
        }
    }
}

/// The first line of what was printed, short enough for a sentence.
fn shown(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let line = text.trim().lines().next().unwrap_or_default();
    text::excerpt(line, 60)
}

impl Drop for Steps {
    fn drop(&mut self) {
        // The end of its input, which tells it to end.
        let _ = self.stream.shutdown(Shutdown::Both);
        self.keeper.end();
    }
}
