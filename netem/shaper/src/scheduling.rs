//! Scheduling for threads that must wake on time, and how a report puts it.

use clock::scheduling::{Granted, ask};
use link::certificate::Scheduling;

/// Requests `SCHED_FIFO` at `priority` (1 to 99) for the calling thread, and sleeps that end on time
/// instead of up to 50 us later. Both are optional: a thread that does not get them plays all the
/// same, and the report says so.
pub(crate) fn prefer_this_thread(priority: u8) -> Granted {
    let granted = ask(Some(priority));
    if let Some(reason) = &granted.refused {
        tracing::info!(reason, "the thread was granted less than it asked for");
    }
    granted
}

/// What was granted, as a report has it.
pub(crate) fn reported(granted: &Granted) -> Scheduling {
    match granted.fifo_priority {
        Some(_) => Scheduling::Fifo,
        None => Scheduling::Other,
    }
}
