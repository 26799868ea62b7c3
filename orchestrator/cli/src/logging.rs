//! Log lines on standard error, chosen by `RUST_LOG`; nothing is logged per tick or message.

use std::io::IsTerminal;

use tracing_subscriber::EnvFilter;

use crate::argument::{Argument, LogFormat};

/// Starts logging. The writer has no thread of its own: a run's processes log only a few lines, at
/// start and end, and a process can only enter a user namespace while it has one thread.
pub(crate) fn start(argument: &Argument) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    let builder = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(std::io::stderr)
        // It would panic where standard error cannot be written.
        .log_internal_errors(false);
    match argument.log_format {
        LogFormat::Text => builder.with_target(false).without_time().init(),
        LogFormat::Json => builder.json().init(),
    }
}
