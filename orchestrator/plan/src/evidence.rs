//! What the verdict on a run rests on, as its manifest has it. How each comes about, and what follows from it, `judge`
//! says; whoever reads a manifest needs no more than this.

use link::certificate::Pause;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::allowance::TAILS;

/// What the messages say of the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Messages {
    /// From controller to plant.
    pub up: Crossed,
    /// From plant to controller.
    pub down: Crossed,
    /// Messages that were back sooner than the link lets them: one clock has both stamps.
    pub back_sooner: u64,
    /// Messages with a stamp outside the time of the run.
    pub outside: u64,
    /// Answers that the plant's own record of arrivals does not bear out.
    pub unborne: u64,
    /// Messages without the time of their sending: how long they were under way up is not known.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unstamped: u64,
    /// Messages without the time of their receipt, whose program left no rows: how long their answers were under way
    /// down is not known.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unreceipted: u64,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Messages {
    /// What cannot be judged of a program of one's own, since its messages do not show it; empty if nothing.
    #[must_use]
    pub fn unknown(&self) -> Vec<&'static str> {
        let up = "the way up, since its messages have no t_send_ns";
        let down = "the way down, since it writes no messages.csv";
        let all = [(self.unstamped, up), (self.unreceipted, down)];
        let all = all.into_iter().filter(|(count, _)| *count > 0);
        all.map(|(_, what)| what).collect()
    }
}

/// What else on a way would have been found out: a part of its messages, at least, later than the quickest tenth by at
/// least so much.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shows {
    /// How much later, ms.
    pub later_ms: f64,
    /// The part, 0 to 1, of those whose lateness is known.
    pub share: f64,
}

/// What the messages say of one way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crossed {
    /// Messages that crossed it.
    pub count: u64,
    /// Those that were quicker than the link lets them.
    pub quicker: u64,
    /// Those whose lateness is known: no loss, no stall and no fault that was asked for excuses it.
    #[serde(default)]
    pub judged: u64,
    /// How much later than the link a tenth of these are at most, ms; 0 if they are too few to say.
    pub excess_p10_ms: f64,
    /// Half of them.
    pub excess_p50_ms: f64,
    /// Ninety-nine of a hundred.
    pub excess_p99_ms: f64,
    /// What else would have been found out; not there if they are too few to say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shows: Option<Shows>,
    /// Those that are late and that no loss of the link excuses.
    pub late: u64,
    /// Those of them that came as late as a resend.
    pub resent: u64,
    /// Those that may have been lost, by the link's slots, expected.
    pub lost_due: f64,
    /// Those of them that came as late as a resend, or never.
    pub lost: u64,
    /// The variance of what is lost: [`Crossed::lost_due`] of messages by themselves, more of those that
    /// enter together and meet one slot of the link. Known to who held them, and not written.
    #[serde(skip)]
    pub lost_variance: f64,
    /// How many were later than the quickest tenth by more than each step of their client's
    /// [tail](crate::Allowance::tail). Known to who held them, and not written.
    #[serde(skip)]
    pub beyond: [u64; TAILS],
}

/// What threads saw that wake each millisecond, one on each processor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Processors that had one.
    pub processors: usize,
    /// Whether they had real-time scheduling, ahead of every part of the run.
    pub real_time: bool,
    /// Beats of all of them.
    pub beats: u64,
    /// The longest that a beat was late, ms.
    pub longest_ms: f64,
    /// What the host took from this machine's processors meanwhile, ms of one processor.
    pub stolen_ms: f64,
    /// Beats that were late by 2 ms or more: the first two hundred of each processor.
    pub gaps: Vec<Pause>,
}

/// What was seen of a process from outside while the controller ran.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Watched {
    /// How often it was looked at.
    pub looks: u64,
    /// How often it was stopped then, by a signal or a debugger.
    pub stopped: u64,
    /// When it was first seen stopped, monotonic.
    pub stopped_at_ns: u64,
    /// How long its threads ran, ms in sum; 0 where that was not looked at.
    pub ran_ms: f64,
    /// How long they waited, ready, for a processor, ms in sum.
    pub waited_ms: f64,
    /// Share of all processors' time that went to what is no part of the run, 0 to 1.
    pub others: f64,
}

/// How far the ends were replayed. All of it agreed, or there is a reason against the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ends {
    /// Ticks whose input and output follow from the commands by the plan's plant; 0 for a program of one's own.
    pub ticks: u64,
    /// Commands that follow from the outputs by the plan's law; 0 for a program of one's own.
    pub commands: u64,
}
