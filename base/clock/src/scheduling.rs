//! Requests real-time scheduling from the kernel, and records what it granted.
//!
//! Best effort, since many machines and most containers refuse it: a run goes on without it, and its
//! reports say so, in words of their own.

use std::num::NonZeroU64;

use rustix::thread::{current_timer_slack, set_current_timer_slack};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id, thread_schedule_policy_param,
};

/// What a thread asked for and what it has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Granted {
    /// The `SCHED_FIFO` priority asked for (1 to 99); none if not asked.
    pub asked_priority: Option<u8>,
    /// Its priority if it has `SCHED_FIFO`: it then runs whenever it can, before all ordinary threads. None if it
    /// has `SCHED_OTHER`, or whatever else an ordinary thread has.
    pub fifo_priority: Option<i32>,
    /// How late the kernel may let its timers be, to gather them. A `SCHED_FIFO` thread has none, whatever this
    /// says.
    pub slack_ns: u64,
    /// Why less was granted than was asked.
    pub refused: Option<String>,
}

impl Granted {
    /// What a thread has that requested nothing, with Linux's defaults.
    #[must_use]
    pub fn ordinary() -> Self {
        Self {
            asked_priority: None,
            fifo_priority: None,
            slack_ns: 50_000,
            refused: None,
        }
    }
}

/// Requests for the calling thread the least timer slack, and `SCHED_FIFO` with this priority if one
/// is given. Never fails; threads that it starts later inherit what it gets.
pub fn ask(asked_priority: Option<u8>) -> Granted {
    let mut refused = Vec::new();
    if let Err(error) = set_current_timer_slack(NonZeroU64::new(1)) {
        refused.push(format!("timer slack of 1 ns: {error}"));
    }
    let thread = thread_native_id();
    if let Some(priority) = asked_priority {
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let result = ThreadPriority::try_from(priority)
            .map_err(ToOwned::to_owned)
            .and_then(|priority| {
                set_thread_priority_and_policy(thread, priority, fifo)
                    .map_err(|error| format!("{error:?}"))
            });
        if let Err(error) = result {
            refused.push(format!(
                "SCHED_FIFO {priority}: {error} (it needs CAP_SYS_NICE or an rtprio limit)"
            ));
        }
    }
    let fifo_priority = match thread_schedule_policy_param(thread) {
        Ok((ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo), param)) => {
            Some(param.sched_priority)
        }
        _ => None,
    };
    Granted {
        asked_priority,
        fifo_priority,
        slack_ns: current_timer_slack().unwrap_or_default(),
        refused: (!refused.is_empty()).then(|| refused.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_recorded_is_what_was_granted_or_says_why_not() {
        // In a thread of its own, since the scheduling stays with the thread.
        let granted = std::thread::spawn(|| ask(Some(10)))
            .join()
            .expect("ask never fails");
        assert_eq!(granted.asked_priority, Some(10));
        match granted.fifo_priority {
            Some(priority) => assert_eq!(priority, 10),
            None => assert!(granted.refused.is_some_and(|why| why.contains("FIFO"))),
        }
    }

    #[test]
    fn a_priority_that_does_not_exist_is_refused_and_not_a_panic() {
        let granted = std::thread::spawn(|| ask(Some(200)))
            .join()
            .expect("ask never fails");
        assert_eq!(granted.fifo_priority, None);
        assert!(granted.refused.is_some());
    }
}
