//! How a process ended, as an exit code.

use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;

/// The exit code of a role that says that something is missing.
pub const UNSUPPORTED: i32 = 3;

/// The exit code as a shell reports it: 128 plus the signal's number if a signal ended the process.
#[must_use]
pub fn exit_code(status: ExitStatus) -> i32 {
    status
        .code()
        .unwrap_or_else(|| 128 + status.signal().unwrap_or_default())
}
