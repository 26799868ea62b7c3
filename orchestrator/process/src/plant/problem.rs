//! What a program did in place of what a plant has to do.

use std::fmt;
use std::io::{self, ErrorKind};
use std::time::Duration;

/// A program that is no plant, or no longer one.
#[derive(Debug, thiserror::Error)]
#[error("the plant's program `{program}` {problem}")]
pub struct BrokenPlant {
    /// The program and its arguments.
    pub program: String,
    /// What it did.
    pub problem: PlantProblem,
}

/// What such a program did.
#[derive(Debug, thiserror::Error)]
pub enum PlantProblem {
    /// It cannot be started.
    #[error("cannot be started: {reason}{}", remedy(.reason))]
    Start {
        /// The system's reason.
        reason: io::Error,
    },
    /// It printed something before it got a u.
    #[error("printed `{printed}` before u of step {step}; it must print one line for each u")]
    Early {
        /// Its line, shortened.
        printed: String,
        /// Number of the step, from 0.
        step: u64,
    },
    /// It printed a line that is none of numbers.
    #[error(
        "printed `{printed}` as {due}, which is no number; it must print nothing but y, and all else on standard error"
    )]
    NoNumber {
        /// Its line, shortened.
        printed: String,
        /// In place of what.
        due: Due,
    },
    /// It printed a line with more or fewer numbers than its first.
    #[error(
        "printed `{printed}` as {due}, and its first line had {}; every line must have as many",
        if *.first == 1 { "one number" } else { "two numbers" }
    )]
    OtherCount {
        /// Its line, shortened.
        printed: String,
        /// In place of what.
        due: Due,
        /// How many numbers its first line had.
        first: usize,
    },
    /// It printed nothing in time.
    #[error(
        "did not print {due} within {} s; it must print a line, and flush it, before it reads the next u",
        .within.as_secs()
    )]
    Late {
        /// What it did not print.
        due: Due,
        /// How long it had for it.
        within: Duration,
    },
    /// It printed a line without an end.
    #[error(
        "printed a line of more than {} bytes as {due}; a line has one number, or two with a comma between \
         them",
        super::LINE_BYTES
    )]
    Long {
        /// In place of what.
        due: Due,
    },
    /// It closed its output.
    #[error("closed its output before {0}; it must go on until its input ends")]
    Closed(Due),
    /// It ended.
    #[error("{} before {due}; it must go on until its input ends", end(*.code))]
    Ended {
        /// Its exit code, as a shell has it.
        code: i32,
        /// What it had not printed yet.
        due: Due,
    },
}

/// What a program is to print next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// The y that it starts with.
    First,
    /// The y of a step, from 0.
    Step(u64),
}

impl fmt::Display for Due {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Due::First => f.write_str("its first y"),
            Due::Step(step) => write!(f, "y of step {step}"),
        }
    }
}

/// How a program ended.
fn end(code: i32) -> String {
    match code {
        129.. => format!("was ended by signal {}", code - 128),
        _ => format!("ended with exit code {code}"),
    }
}

/// What to do about a program that cannot be started, behind the system's reason.
fn remedy(problem: &io::Error) -> &'static str {
    /// The kernel's ENOEXEC: a script without a first line that names its interpreter.
    const NO_FORMAT: i32 = 8;
    match problem.kind() {
        ErrorKind::NotFound => "; name a program that is in PATH, or give its path",
        ErrorKind::PermissionDenied => {
            "; make it executable, or put its interpreter before it, like python3"
        }
        _ if problem.raw_os_error() == Some(NO_FORMAT) => {
            "; put its interpreter before it, like python3, or begin it with a line like #!/usr/bin/env python3"
        }
        _ => "",
    }
}
