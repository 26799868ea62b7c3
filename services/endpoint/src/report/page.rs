//! The page's report of a run, as the page writes it and the plant stores it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Number;

use crate::controller::Counts;
use crate::page::{Sender, Thread, Timer};
use crate::setting::{Connection, Integrate, Late, Mode, Outstanding, Schedule, Transport};

/// What a page tells when it has ended. What JavaScript writes without a point where it is whole is
/// a [`Number`] here, so that it stays as it was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Page {
    /// `complete`, `late`, `failed` or `stopped`.
    pub outcome: String,
    /// Why, in a sentence; empty where it is complete.
    pub reason: String,
    /// The first deadline, on the run's clock, if it came to one.
    pub start_ns: Option<u64>,
    /// Where the deadlines ended, likewise.
    pub stop_ns: Option<u64>,
    /// What became of the deadlines.
    pub counts: Counts,
    /// Why the first message failed that did.
    pub first_failure: Option<String>,
    /// What the browser calls itself.
    pub user_agent: String,
    /// Whether it is cross-origin isolated, so that its clock is fine.
    pub isolated: bool,
    /// Whether its context counts as secure.
    pub secure: bool,
    /// Whether it was hidden at any time.
    pub hidden: bool,
    /// The page's clock.
    pub clock: Clock,
    /// The least that its timers within timers wait, ms; none where that was not measured.
    pub timer_clamp_ms: Option<Number>,
    /// The least delay that its timers were given, ms.
    pub timer_floor_ms: Number,
    /// Messages a second that were asked for.
    pub rate_asked_hz: Option<Number>,
    /// Messages a second that were sent.
    pub rate_achieved_hz: Option<Number>,
    /// What it was asked for.
    pub settings: PageAsked,
}

/// How honest a page's clock is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clock {
    /// `given` by whoever started it, or `measured` against the plant's.
    pub source: Option<String>,
    /// The step in which it counts, us.
    pub step_us: Option<Number>,
    /// How far it was off the plant's at the end, ms.
    pub error_ms: Option<Number>,
}

/// A page's settings, in its own words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PageAsked {
    /// Closed loop or open.
    pub mode: Mode,
    /// The sample time; none where it never heard the plant's.
    pub h_ns: Option<u64>,
    /// The reference r.
    pub r: Number,
    /// Deadlines end this long after the first.
    pub duration_ns: u64,
    /// When messages are due.
    pub schedule: Schedule,
    /// What the law integrates over.
    pub integrate: Integrate,
    /// What becomes of late commands; none where it never heard the plant's.
    pub late: Option<Late>,
    /// When a message is given up.
    pub timeout_ns: u64,
    /// Messages under way at one time.
    pub outstanding: Outstanding,
    /// Only where its address named it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connection: Option<Connection>,
    /// What carries the messages.
    pub transport: Transport,
    /// Where the loop runs.
    pub thread: Thread,
    /// What sends its requests.
    pub sender: Sender,
    /// What it waits for a deadline with.
    pub timer: Timer,
    /// The least delay that a timer is given.
    pub floor_ns: u64,
    /// How long it draws in each 100 ms, beside the loop.
    #[serde(default)]
    pub chores_ns: u64,
}
