//! The tables by their names, and what a table has. Each is in the file of its contenders.
//!
//! A goal is what webloop strives for on a machine of two cores; docs/performance.md has what was reached.

use crate::contender::Contender;
use crate::{
    browser, cell, crossing, memory, rate, report, rows, step, stream, tick, virtual_time,
};

endpoint::choice!(
    /// A table of contenders.
    Group, "table", "step, rate, tick, delay, stream, virtual, rows, cell, memory, report, browser or compose", {
        /// A message and its answer, back to back.
        Step = "step",
        /// A loop at 10 kHz.
        Rate = "rate",
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
        /// Memory of roles, and of a message under way.
        Memory = "memory",
        /// The report on a campaign.
        Report = "report",
        /// Deadlines that browsers keep.
        Browser = "browser",
        /// What a cell in containers takes beyond its loop.
        Compose = "compose",
    }
);

/// What a contender should come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    /// Whose goal it is.
    pub(crate) contender: &'static str,
    /// Which figure.
    pub(crate) figure: &'static str,
    /// Another contender whose figure it is to be a multiple of; else it is the figure itself.
    pub(crate) times: Option<&'static str>,
    /// The bound.
    pub(crate) bound: Bound,
}

/// A bound of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

impl Bound {
    /// Whether a value keeps it.
    pub(crate) fn is_met(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::AtLeast(least) => value >= least,
        }
    }
}

/// A table: what it compares, by whose figures, and what webloop strives for.
#[derive(Debug)]
pub(crate) struct Table {
    /// What it compares.
    pub(crate) about: &'static str,
    /// The contender to which the others are compared, if they are of a kind.
    pub(crate) base: Option<&'static str>,
    /// On how many processors all is that a contender starts, if not on all there are.
    pub(crate) processors: Option<usize>,
    /// Those it compares, in the order of measuring.
    pub(crate) contenders: &'static [Contender],
    /// What webloop strives for.
    pub(crate) goals: &'static [Goal],
}

pub(crate) const fn goal(
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

impl Group {
    /// How often it is measured at the most.
    pub(crate) fn most_times(self) -> u32 {
        match self {
            // A quarter of a minute a page.
            Group::Browser => 2,
            _ => u32::MAX,
        }
    }

    /// The table.
    pub(crate) fn table(self) -> &'static Table {
        match self {
            Group::Step => &step::TABLE,
            Group::Rate => &rate::TABLE,
            Group::Tick => &tick::TABLE,
            Group::Delay => &crossing::TABLE,
            Group::Stream => &stream::TABLE,
            Group::Virtual => &virtual_time::TABLE,
            Group::Rows => &rows::TABLE,
            Group::Cell => &cell::TABLE,
            Group::Memory => &memory::TABLE,
            Group::Report => &report::TABLE,
            Group::Browser => &browser::TABLE,
            Group::Compose => &cell::IN_CONTAINERS,
        }
    }
}
