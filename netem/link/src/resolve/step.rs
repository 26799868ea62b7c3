//! The steps of a trace: how many there may be, and which can follow which, wherever they are written.

use super::loss::too_slow;
use crate::describe::time;
use crate::trace::Step;

/// Most steps of a trace: an hour at 200 a second, or a day at ten. In memory they take 40 MB.
pub(super) const MOST_STEPS: usize = 1_000_000;

/// What is wrong with a step, or with the file that has it, and what to do about it.
#[derive(Debug)]
pub(super) struct Wrong {
    pub(super) message: String,
    pub(super) remedy: String,
}

impl Wrong {
    pub(super) fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            remedy: remedy.into(),
        }
    }

    pub(super) fn too_many_steps() -> Self {
        let message = format!("the trace has more than {MOST_STEPS} steps");
        Self::new(message, "leave out steps, or cut the trace")
    }
}

/// Checks that a step can follow those before it.
pub(super) fn follows(before: &[Step], step: &Step) -> Result<(), Wrong> {
    let at = |step: &Step| time(step.t_ns as f64);
    match before.last() {
        None if step.t_ns != 0 => {
            let message = format!("the first step is at {}, not at 0", at(step));
            let remedy = format!(
                "count from the trace's beginning: take {} from each time",
                at(step)
            );
            return Err(Wrong::new(message, remedy));
        }
        Some(last) if step.t_ns == last.t_ns => {
            let message = format!("two steps at {}", at(step));
            return Err(Wrong::new(message, "keep one of them"));
        }
        Some(last) if step.t_ns < last.t_ns => {
            let message = format!("a step at {} after one at {}", at(step), at(last));
            return Err(Wrong::new(message, "sort the steps by their times"));
        }
        Some(last) if step.rate_bps.is_some() != last.rate_bps.is_some() => {
            let message = "some steps have a rate and some have none";
            return Err(Wrong::new(message, "give every step a rate, or none"));
        }
        _ => {}
    }
    match step.rate_bps.and_then(too_slow) {
        None => Ok(()),
        Some(wrong) => {
            let remedy = "write a greater rate; an outage is a loss of 100 %";
            Err(Wrong::new(wrong, remedy))
        }
    }
}
