//! Exit codes by kind, decided in one place.

use std::process::ExitCode;

/// How a command ended, as its caller's shell sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// All that was asked was done, and what was checked held.
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

/// Anything else that went wrong while a command ran; what the shaper finds missing is told from
/// what failed, so that whoever started a role knows it too.
impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        let kind = match error.downcast_ref() {
            Some(shaper::Error::Unsupported { .. }) => Exit::Unsupported,
            _ => Exit::Failed,
        };
        Failure { kind, error }
    }
}

/// What a command gives back.
pub(crate) type Outcome = Result<Exit, Failure>;

/// Says an error on standard error and gives the exit code.
pub(crate) fn end(outcome: Outcome) -> ExitCode {
    let exit = outcome.unwrap_or_else(|failure| {
        // A reader that has gone away, as in `webloop show DIR | head`, is no error of ours.
        let gone = failure
            .error
            .downcast_ref::<std::io::Error>()
            .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe);
        if gone {
            return Exit::Fine;
        }
        eprintln!("webloop: {}", sentence(&failure.error));
        failure.kind
    });
    ExitCode::from(exit as u8)
}

/// An error and its causes in one line. Many errors quote their cause; it is not said twice.
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
