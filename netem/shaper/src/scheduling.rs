//! Scheduling for threads that must wake on time.

use std::num::NonZeroU64;

use certificate::Scheduling;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Requests `SCHED_FIFO` at `priority` (1 to 99) for the calling thread, and sleeps that end on time
/// instead of up to 50 us later. Both are optional: a thread that does not get them plays all the
/// same, and the report says so.
pub(crate) fn prefer_this_thread(priority: u8) -> Scheduling {
    if let Err(error) = rustix::thread::set_current_timer_slack(NonZeroU64::new(1)) {
        tracing::debug!(%error, "the timer slack stays as it was");
    }
    let fifo = ThreadPriority::try_from(priority).and_then(|priority| {
        set_thread_priority_and_policy(
            thread_native_id(),
            priority,
            ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
        )
        .map_err(|_| "SCHED_FIFO is refused (root, or RLIMIT_RTPRIO, is needed)")
    });
    match fifo {
        Ok(()) => Scheduling::Fifo,
        Err(reason) => {
            tracing::info!(reason, "the thread stays with SCHED_OTHER");
            Scheduling::Other
        }
    }
}
