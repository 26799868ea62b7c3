//! The thread of a probe, or of half of one.

use std::thread;

use crate::error::{Doing, Result};
use crate::scheduling::prefer_this_thread;

/// Just above the player: a probe that is held up between reading the clock and sending would measure
/// itself. It needs almost no processor time.
const PRIORITY: u8 = 49;

/// The longest sleep, so that a request to stop is seen soon.
pub(crate) const LONGEST_SLEEP_NS: u64 = 50_000_000;

/// Runs a probe, or half of one, on a thread of its own, and waits for it.
pub(crate) fn on_a_thread<T: Send>(
    name: &str,
    probing: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    thread::scope(|scope| {
        thread::Builder::new()
            .name(name.into())
            .spawn_scoped(scope, || {
                prefer_this_thread(PRIORITY);
                probing()
            })
            .doing("start the thread that probes")?
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
