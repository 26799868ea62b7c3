//! Log lines on standard error, chosen by `RUST_LOG`; nothing is logged per tick or message.

use std::io::IsTerminal;

use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::argument::{Argument, LogFormat};

/// Starts logging. The writer has no thread of its own: a run's processes log only a few lines, at
/// start and end, and a process can only enter a user namespace while it has one thread.
pub(crate) fn start(argument: &Argument) {
    let lines = tracing_subscriber::fmt::layer()
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(std::io::stderr)
        // It would panic where standard error cannot be written.
        .log_internal_errors(false);
    let shown = tracing_subscriber::registry().with(shown());
    match argument.log_format {
        LogFormat::Text => shown.with(lines.with_target(false).without_time()).init(),
        LogFormat::Json => shown.with(lines.json()).init(),
    }
}

/// Levels by crate, as in `info,link=debug`: warnings and errors where `RUST_LOG` says nothing, or nothing that can be
/// read.
fn shown() -> Targets {
    let asked = std::env::var("RUST_LOG").ok();
    let asked = asked.and_then(|text| text.parse().ok());
    asked.unwrap_or_else(|| Targets::new().with_default(LevelFilter::WARN))
}
