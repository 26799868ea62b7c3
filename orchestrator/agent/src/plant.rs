//! A plant of somebody's own: a program that advances by h for each u that it reads, and prints y.
//!
//! Its standard input and output are one socket, a line a number, or two with a comma between them: first it
//! prints the y that it starts with, then one y after each u. It ends when its input does.
//! docs/your-plant.md is its contract. What time a step has is the caller's matter; here a step that takes too
//! long breaks it.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use endpoint::{Model, Signals, report};

use crate::keeper::{END_WITHIN, Keeper};

/// Longest line that it may print, bytes.
const LINE_BYTES: usize = 4096;

/// A program to be started as a plant.
#[derive(Debug)]
pub struct Start<'a> {
    /// The program and its arguments.
    pub run: &'a [String],
    /// What its environment has in addition to this process's.
    pub environment: Vec<(&'static str, OsString)>,
    /// How many inputs it has: 1 or 2.
    pub inputs: usize,
    /// What a step advances by, ns: a step that takes longer is counted.
    pub h_ns: u64,
    /// How long it may take from its start to its first y.
    pub start_within: Duration,
    /// How long a step may take before the program counts as broken.
    pub step_within: Duration,
    /// Whether to take from it what a plant does not need, where this user may: then this process's own
    /// program must be webloop.
    pub is_confined: bool,
}

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
    /// A sentence about the program: it cannot be started, or what it does in place of printing a number.
    pub fn start(start: &Start<'_>) -> Result<PlantProgram, String> {
        let name = start.run.join(" ");
        let fail = |problem: io::Error| {
            format!("the plant's program `{name}` cannot be started: {problem}")
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
        };
        let at_rest = steps.answer("its first y", start.start_within)?;
        Ok(PlantProgram {
            steps: Arc::new(Mutex::new(steps)),
            at_rest,
            inputs: start.inputs,
        })
    }

    /// Why it steps no more, as a sentence; `None` if it does.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.lock().problem.clone()
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
    problem: Option<String>,
    report: report::PlantProgram,
    h_ns: u64,
    /// How many numbers its first line had.
    outputs: Option<usize>,
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
                self.problem = Some(problem);
                f64::NAN.into()
            }
        }
    }

    fn exchange(&mut self, u: Signals) -> Result<Signals, String> {
        let step = self.report.steps;
        if !self.unread.is_empty() {
            let printed = shown(&self.unread);
            let name = &self.name;
            return Err(format!(
                "the plant's program `{name}` printed `{printed}` before u of step {step}; it must print \
                 one line for each u"
            ));
        }
        let mut line = String::with_capacity(32);
        let _ = writeln!(line, "{u}");
        match self.stream.write_all(line.as_bytes()) {
            Ok(()) => self.answer(&format!("y of step {step}"), self.step_within),
            Err(_) => Err(self.ended(&format!("y of step {step}"))),
        }
    }

    /// The next line that it prints, as numbers; `what` says which, in errors.
    fn answer(&mut self, what: &str, within: Duration) -> Result<Signals, String> {
        let line = self.line(what, within)?;
        let text = String::from_utf8_lossy(&line);
        let printed = |problem: &str| {
            let (name, shown) = (&self.name, shown(&line));
            format!("the plant's program `{name}` printed `{shown}` as {what}, {problem}")
        };
        let y: Signals = text
            .trim()
            .parse()
            .map_err(|_| printed("which is no number"))?;
        match self.outputs {
            Some(outputs) if outputs != y.count() => {
                let numbers = if outputs == 1 {
                    "one number"
                } else {
                    "two numbers"
                };
                Err(printed(&format!("and its first line had {numbers}")))
            }
            _ => {
                self.outputs = Some(y.count());
                Ok(y)
            }
        }
    }

    fn line(&mut self, what: &str, within: Duration) -> Result<Vec<u8>, String> {
        let late = format!(
            "the plant's program `{}` did not print {what} within {} s",
            self.name,
            within.as_secs()
        );
        let deadline = Instant::now() + within;
        let mut part = [0; 512];
        loop {
            if let Some(end) = self.unread.iter().position(|byte| *byte == b'\n') {
                return Ok(self.unread.drain(..=end).collect());
            }
            if self.unread.len() > LINE_BYTES {
                return Err(format!(
                    "the plant's program `{}` printed a line of more than {LINE_BYTES} bytes as {what}",
                    self.name
                ));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || self.stream.set_read_timeout(Some(left)).is_err() {
                return Err(late);
            }
            match self.stream.read(&mut part) {
                Ok(0) => return Err(self.ended(what)),
                Ok(length) => self.unread.extend_from_slice(&part[..length]),
                Err(problem) => match problem.kind() {
                    ErrorKind::Interrupted => {}
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => return Err(late),
                    _ => return Err(self.ended(what)),
                },
            }
        }
    }

    /// Why there is no answer from a program whose end of the socket is closed.
    fn ended(&self, what: &str) -> String {
        let how = match self.keeper.code_within(END_WITHIN) {
            None => "closed its output".to_owned(),
            Some(code @ 129..) => format!("was ended by signal {}", code - 128),
            Some(code) => format!("ended with exit code {code}"),
        };
        format!("the plant's program `{}` {how} before {what}", self.name)
    }
}

/// The first line of what was printed, short enough for a sentence.
fn shown(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let line = text.trim().lines().next().unwrap_or_default();
    let start: String = line.chars().take(60).collect();
    endpoint::plain(&start).into_owned()
}

impl Drop for Steps {
    fn drop(&mut self) {
        // The end of its input, which tells it to end.
        let _ = self.stream.shutdown(Shutdown::Both);
        self.keeper.end();
    }
}
