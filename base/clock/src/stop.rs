//! The signals that end a process.

use std::io;

use tokio::signal::unix::{SignalKind, signal};

/// Waits until this process gets SIGTERM or SIGINT. From the first poll on, these signals do not kill
/// the process.
///
/// # Errors
/// The system's error if a signal cannot be handled.
pub async fn told_to_end() -> io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    tokio::select! {
        _ = terminate.recv() => {}
        _ = interrupt.recv() => {}
    }
    Ok(())
}
