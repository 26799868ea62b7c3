//! A recorded link: steps of delay, and of loss and rate if they are given; where it begins, and whether it
//! begins again.

use std::ops::Range;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::draws::Draws;

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

impl Step {
    /// Whether a packet meets the same in both.
    fn is_like(&self, other: &Step) -> bool {
        Step { t_ns: 0, ..*self } == Step { t_ns: 0, ..*other }
    }
}

/// What follows the last step of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Then {
    /// The trace begins again at this time of it, which is its span.
    Again { span_ns: u64 },
    /// The last step is held for ever.
    Hold,
}

/// Where in a trace the link begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Start {
    /// At an instant of the trace that the seed draws, the same share of the span in both directions.
    Drawn,
    /// At this time of the trace.
    At { t_ns: u64 },
}

/// Edition of the profile format: what a trace does where its profile does not say so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Edition {
    /// It begins with its first step and holds its last: how the first plans read it.
    First,
    /// It begins at an instant that the seed draws, and begins again at its end.
    #[default]
    Second,
}

impl Edition {
    /// The edition of a plan that does not name one.
    #[must_use]
    pub const fn first() -> Self {
        Self::First
    }

    /// Whether it is the one that a plan need not name.
    #[must_use]
    pub fn is_first(&self) -> bool {
        *self == Self::First
    }
}

/// Steps from time 0 on, each later than the one before.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Trace {
    steps: Arc<[Step]>,
    then: Then,
    start: Start,
}

impl Trace {
    /// A trace. The resolver has checked that there is a first step, at time 0, that times increase, that a
    /// span is later than the last, that the start is within it, and that nothing is drawn without a span.
    pub(crate) fn new(steps: Vec<Step>, then: Then, start: Start) -> Self {
        Self {
            steps: steps.into(),
            then,
            start,
        }
    }

    /// The steps in order of time.
    pub(crate) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// What follows the last step.
    pub(crate) fn then(&self) -> Then {
        self.then
    }

    /// Where the link begins in it.
    pub(crate) fn start(&self) -> Start {
        self.start
    }

    /// The time after which it begins again; `None` if it does not.
    pub(crate) fn span_ns(&self) -> Option<u64> {
        match self.then {
            Then::Again { span_ns } => Some(span_ns),
            Then::Hold => None,
        }
    }

    /// How long its last step lasts if nobody says: the median length of the others, of two in the middle the
    /// shorter; `None` for a trace of one step, which is the same at all times.
    pub(crate) fn usual_length_ns(steps: &[Step]) -> Option<u64> {
        let mut lengths: Vec<u64> = steps
            .windows(2)
            .map(|pair| pair[1].t_ns - pair[0].t_ns)
            .collect();
        let middle = lengths.len().checked_sub(1)? / 2;
        Some(*lengths.select_nth_unstable(middle).1)
    }

    /// Whether each seed has its own beginning, and it matters.
    pub(crate) fn is_drawn(&self) -> bool {
        let is_level = || self.steps.iter().all(|step| step.is_like(&self.steps[0]));
        self.start == Start::Drawn && self.span_ns().is_some() && !is_level()
    }

    /// The same trace, which begins where the seed says. Both directions of a link have the same draw, so
    /// traces of one span, as they are halves of the same round trips, stay in step.
    pub(crate) fn begun(&self, seed: u64) -> Self {
        match self.start {
            Start::Drawn => self.begun_at(Draws::new(seed, b"trace.at").at(0)),
            Start::At { .. } => self.clone(),
        }
    }

    /// The same trace, which begins at this share of its span if its start is drawn.
    pub(crate) fn begun_at(&self, share: f64) -> Self {
        let t_ns = match (self.start, self.then) {
            (Start::At { t_ns }, _) => t_ns,
            (Start::Drawn, Then::Again { span_ns }) => {
                ((share * span_ns as f64) as u64).min(span_ns - 1)
            }
            (Start::Drawn, Then::Hold) => 0,
        };
        Self {
            start: Start::At { t_ns },
            ..self.clone()
        }
    }

    /// The step in force at link time `t_ns`, and the link times of its beginning and of the next
    /// step; the last step of a trace that does not begin again has no end.
    pub(crate) fn step_at(&self, t_ns: u64) -> (Range<u64>, Step) {
        let ahead_ns = match self.start {
            Start::At { t_ns } => t_ns,
            Start::Drawn => 0,
        };
        let t_ns = t_ns.saturating_add(ahead_ns);
        let within_ns = self.span_ns().map_or(t_ns, |span_ns| t_ns % span_ns);
        let round_ns = t_ns - within_ns;
        let after = self.steps.partition_point(|step| step.t_ns <= within_ns);
        let step = self.steps[after.saturating_sub(1)];
        let next_ns = self.steps.get(after).map(|step| step.t_ns);
        let end_ns = next_ns.or(self.span_ns());
        let end_ns = end_ns.map_or(u64::MAX, |end_ns| {
            round_ns.saturating_add(end_ns).saturating_sub(ahead_ns)
        });
        // The link begins within a step.
        let start_ns = (round_ns + step.t_ns).saturating_sub(ahead_ns);
        (start_ns..end_ns, step)
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
