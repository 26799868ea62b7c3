//! The tables: which figures of which contenders, and the goals.
//!
//! A goal is what webloop strives for on a machine of two cores; docs/performance.md has what was reached.

use crate::contender::Contender;
use crate::{cell, crossing, rows, step, stream, tick, virtual_time};

endpoint::choice!(
    /// A table of contenders.
    Group, "table", "step, tick, delay, stream, virtual, rows or cell", {
        /// A message and its answer, back to back.
        Step = "step",
        /// Ticks every millisecond.
        Tick = "tick",
        /// A link of 5 ms.
        Delay = "delay",
        /// A TCP stream across a link of no delay.
        Stream = "stream",
        /// Seconds of a loop a second.
        Virtual = "virtual",
        /// Rows read and written.
        Rows = "rows",
        /// What a cell takes beyond its loop.
        Cell = "cell",
    }
);

/// What a contender should come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Whose goal it is.
    pub contender: &'static str,
    /// Which figure.
    pub figure: &'static str,
    /// Another contender whose figure it is to be a multiple of; else it is the figure itself.
    pub times: Option<&'static str>,
    /// The bound.
    pub bound: Bound,
}

/// A bound of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

impl Bound {
    /// Whether a value keeps it.
    #[must_use]
    pub fn is_met(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::AtLeast(least) => value >= least,
        }
    }
}

const fn goal(
    contender: &'static str,
    figure: &'static str,
    times: Option<&'static str>,
    bound: Bound,
) -> Goal {
    Goal {
        contender,
        figure,
        times,
        bound,
    }
}

const STEP: [Goal; 4] = [
    goal(
        "webloop, HTTP",
        "p50_us",
        Some(step::BASE),
        Bound::AtMost(2.0),
    ),
    goal(
        "webloop, WebSocket",
        "p50_us",
        Some(step::BASE),
        Bound::AtMost(1.5),
    ),
    goal(
        "the paper's way",
        "p50_us",
        Some("webloop, HTTP"),
        Bound::AtLeast(19.0),
    ),
    goal(
        "the paper's way",
        "p50_us",
        Some("webloop, WebSocket"),
        Bound::AtLeast(25.0),
    ),
];

const TICK: [Goal; 2] = [
    goal(
        "webloop, plant",
        "p99_us",
        Some(tick::BASE),
        Bound::AtMost(1.0),
    ),
    goal(
        "webloop, plant",
        "p99.9_us",
        Some(tick::BASE),
        Bound::AtMost(1.0),
    ),
];

const DELAY: [Goal; 3] = [
    goal("webloop", "p99_us", Some("Rattan"), Bound::AtMost(0.2)),
    goal("webloop", "cpu_pct", Some("Rattan"), Bound::AtMost(1.0)),
    goal("webloop, 100 Hz", "p50_us", None, Bound::AtMost(15.0)),
];

const STREAM: [Goal; 2] = [
    goal("webloop", "mbit_s", Some(stream::BASE), Bound::AtLeast(0.5)),
    goal("webloop", "mbit_s", Some("Rattan"), Bound::AtLeast(10.0)),
];

const VIRTUAL: [Goal; 2] = [
    goal("webloop, arima", "x_real", None, Bound::AtLeast(20_000.0)),
    goal("webloop, couva", "x_real", None, Bound::AtLeast(10_000.0)),
];

const ROWS: [Goal; 2] = [
    goal(
        "webloop",
        "read_mb_s",
        Some(rows::BASE),
        Bound::AtLeast(1.4),
    ),
    goal(
        "webloop",
        "write_mb_s",
        Some(rows::BASE),
        Bound::AtLeast(1.0),
    ),
];

const CELL: [Goal; 4] = [
    goal("namespaces, arima", "beyond_ms", None, Bound::AtMost(500.0)),
    goal(
        "namespaces, buccoo",
        "beyond_ms",
        None,
        Bound::AtMost(500.0),
    ),
    goal("namespaces, couva", "beyond_ms", None, Bound::AtMost(500.0)),
    goal("virtual time, arima", "beyond_ms", None, Bound::AtMost(5.0)),
];

impl Group {
    /// What it compares.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Group::Step => "a message and its answer, back to back, both ends on one processor",
            Group::Tick => "ticks every ms: lateness, and the sd of the time between two",
            Group::Delay => "a link of 5 ms: how far from 5 ms the way up is",
            Group::Stream => "one TCP stream across a link of no delay",
            Group::Virtual => "a loop at 1 kHz in virtual time, one processor: seconds a second",
            Group::Rows => "rows of a run, on one processor: read with its metrics, and written",
            Group::Cell => "what a cell takes beyond its loop",
        }
    }

    /// Those it compares, in the order of measuring.
    #[must_use]
    pub fn contenders(self) -> &'static [Contender] {
        match self {
            Group::Step => &step::CONTENDERS,
            Group::Tick => &tick::CONTENDERS,
            Group::Delay => &crossing::CONTENDERS,
            Group::Stream => &stream::CONTENDERS,
            Group::Virtual => &virtual_time::CONTENDERS,
            Group::Rows => &rows::CONTENDERS,
            Group::Cell => &cell::CONTENDERS,
        }
    }

    /// The contender to which the others are compared.
    #[must_use]
    pub fn base(self) -> &'static str {
        match self {
            Group::Step => step::BASE,
            Group::Tick => tick::BASE,
            Group::Delay => crossing::BASE,
            Group::Stream => stream::BASE,
            Group::Virtual => virtual_time::BASE,
            Group::Rows => rows::BASE,
            Group::Cell => cell::BASE,
        }
    }

    /// What webloop strives for.
    #[must_use]
    pub fn goals(self) -> &'static [Goal] {
        match self {
            Group::Step => &STEP,
            Group::Tick => &TICK,
            Group::Delay => &DELAY,
            Group::Stream => &STREAM,
            Group::Virtual => &VIRTUAL,
            Group::Rows => &ROWS,
            Group::Cell => &CELL,
        }
    }
}
