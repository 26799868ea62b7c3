//! A recorded link: steps of delay, and of loss and rate if they are given.

use std::ops::Range;
use std::sync::Arc;

use serde::Serialize;

/// The state from `t_ns` until the next step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Step {
    /// Time of the trace.
    pub(crate) t_ns: u64,
    /// One-way delay.
    pub(crate) delay_ns: u64,
    /// Share of packets lost, 0 to 1.
    pub(crate) loss: f64,
    /// Rate limit, if the trace has one.
    pub(crate) rate_bps: Option<u64>,
}

/// Steps from time 0 on, each later than the one before.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Trace {
    steps: Arc<[Step]>,
    repeat_ns: Option<u64>,
}

impl Trace {
    /// A trace. The resolver has checked that there is a first step, at time 0,
    /// that times increase, and that `repeat_ns` is later than the last.
    pub(crate) fn new(steps: Vec<Step>, repeat_ns: Option<u64>) -> Self {
        Self {
            steps: steps.into(),
            repeat_ns,
        }
    }

    /// The steps in order of time.
    pub(crate) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// When the trace begins again; if `None`, the last step is held forever.
    pub(crate) fn repeat_ns(&self) -> Option<u64> {
        self.repeat_ns
    }

    /// The step in force at link time `t_ns`, and the link times of its beginning and of the next
    /// step; the last step of a trace that does not repeat has no end.
    pub(crate) fn step_at(&self, t_ns: u64) -> (Range<u64>, Step) {
        let within_ns = self.repeat_ns.map_or(t_ns, |repeat_ns| t_ns % repeat_ns);
        let round_ns = t_ns - within_ns;
        let after = self.steps.partition_point(|step| step.t_ns <= within_ns);
        let step = self.steps[after.saturating_sub(1)];
        let next_ns = self.steps.get(after).map(|step| step.t_ns);
        let end_ns = next_ns.or(self.repeat_ns);
        let end_ns = end_ns.map_or(u64::MAX, |end_ns| round_ns.saturating_add(end_ns));
        (round_ns + step.t_ns..end_ns, step)
    }

    pub(crate) fn floor_ns(&self) -> u64 {
        self.steps
            .iter()
            .map(|step| step.delay_ns)
            .min()
            .unwrap_or(0)
    }

    pub(crate) fn reach_ns(&self) -> u64 {
        self.steps
            .iter()
            .map(|step| step.delay_ns)
            .max()
            .unwrap_or(0)
    }

    /// The greatest rate in bit/s; 0 without rates.
    pub(crate) fn greatest_bps(&self) -> u64 {
        let rates = self.steps.iter().filter_map(|step| step.rate_bps);
        rates.max().unwrap_or(0)
    }
}
