//! Exit codes for each kind of outcome, decided in one place.

use std::io;
use std::process::ExitCode;

use campaign::ErrorKind;

/// How a command ended, as its caller's shell sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Everything requested was done, and every check held.
    Fine = 0,
    /// A run failed or is invalid, or a check did not hold.
    Failed = 1,
    /// The command line or a file that it names is wrong.
    Usage = 2,
    /// This machine lacks something.
    Unsupported = 3,
    /// Stopped by SIGINT or SIGTERM.
    Interrupted = 130,
}

/// A command's error, with the exit code of its kind.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Exit,
    error: anyhow::Error,
}

impl Failure {
    /// The command line, or a file it names, is wrong.
    pub(crate) fn usage(error: impl Into<anyhow::Error>) -> Self {
        Failure {
            kind: Exit::Usage,
            error: error.into(),
        }
    }

    /// This machine lacks something.
    pub(crate) fn unsupported(error: impl Into<anyhow::Error>) -> Self {
        Failure {
            kind: Exit::Unsupported,
            error: error.into(),
        }
    }
}

/// Any other error of a command, with its kind if it has one. Something missing and something
/// failed have different codes, so that whoever started a role can tell them apart.
impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        let kind = if let Some(problem) = error.downcast_ref::<campaign::Error>() {
            of_kind(problem.kind())
        } else if let Some(shaper::Error::Unsupported { .. }) = error.downcast_ref() {
            Exit::Unsupported
        } else {
            Exit::Failed
        };
        Failure { kind, error }
    }
}

/// The exit code of a campaign's error.
fn of_kind(kind: ErrorKind) -> Exit {
    match kind {
        ErrorKind::Usage => Exit::Usage,
        ErrorKind::Unsupported => Exit::Unsupported,
        ErrorKind::Other(code) if code == Exit::Usage as i32 => Exit::Usage,
        ErrorKind::Other(code) if code == Exit::Unsupported as i32 => Exit::Unsupported,
        ErrorKind::Failed | ErrorKind::Other(_) => Exit::Failed,
    }
}

/// Result of a command.
pub(crate) type Outcome = Result<Exit, Failure>;

/// Prints an error on standard error and returns the exit code.
pub(crate) fn end(outcome: Outcome) -> ExitCode {
    let exit = outcome.unwrap_or_else(|failure| {
        // It is no error if the reader closes the pipe, as in `webloop show DIR | head`.
        let io = match failure.error.downcast_ref() {
            Some(campaign::Error::Io(error)) => Some(error),
            _ => failure.error.downcast_ref(),
        };
        if io.is_some_and(|error: &io::Error| error.kind() == io::ErrorKind::BrokenPipe) {
            return Exit::Fine;
        }
        // First each damaged file, then the error that follows from them.
        if let Some(campaign::Error::NotWhole { damage, .. }) = failure.error.downcast_ref() {
            for one in damage {
                say!("webloop: {one}");
            }
        }
        say!("{}", words(&failure));
        failure.kind
    });
    ExitCode::from(exit as u8)
}

/// What is printed of an error.
pub(crate) fn words(failure: &Failure) -> String {
    format!("webloop: {}", sentence(&failure.error))
}

/// An error and its causes in one line. Many errors quote their cause; it is not repeated.
fn sentence(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |said, cause| {
        let cause = cause.to_string();
        match said.as_str() {
            "" => cause,
            said if said.contains(&cause) => said.to_owned(),
            said => format!("{said}: {cause}"),
        }
    })
}
