//! Requests real-time scheduling from the kernel, and records what it granted.
//!
//! Best effort, since many machines and most containers refuse it: a run goes on without it, and its
//! manifest says so.

use std::num::NonZeroU64;

use endpoint::report::{Policy, Scheduling};
use rustix::thread::{current_timer_slack, set_current_timer_slack};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id, thread_schedule_policy_param,
};

/// Requests for the calling thread the least timer slack, and `SCHED_FIFO` with this priority if one
/// is given. Never fails; threads that it starts later inherit what it gets.
pub fn ask(fifo_priority: Option<u8>) -> Scheduling {
    let mut refused = Vec::new();
    if let Err(error) = set_current_timer_slack(NonZeroU64::new(1)) {
        refused.push(format!("timer slack of 1 ns: {error}"));
    }
    let thread = thread_native_id();
    if let Some(priority) = fifo_priority {
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
    let (policy, priority) = match thread_schedule_policy_param(thread) {
        Ok((ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo), param)) => {
            (Policy::Fifo, param.sched_priority)
        }
        _ => (Policy::Other, 0),
    };
    Scheduling {
        asked_priority: fifo_priority,
        policy,
        priority,
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
        let scheduling = std::thread::spawn(|| ask(Some(10)))
            .join()
            .expect("ask never fails");
        assert_eq!(scheduling.asked_priority, Some(10));
        match scheduling.policy {
            Policy::Fifo => assert_eq!(scheduling.priority, 10),
            Policy::Other => assert!(scheduling.refused.is_some_and(|why| why.contains("FIFO"))),
        }
    }

    #[test]
    fn a_priority_that_does_not_exist_is_refused_and_not_a_panic() {
        let scheduling = std::thread::spawn(|| ask(Some(200)))
            .join()
            .expect("ask never fails");
        assert_eq!(scheduling.policy, Policy::Other);
        assert!(scheduling.refused.is_some());
    }
}
