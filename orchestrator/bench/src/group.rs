//! The tables by their names. Each is in the file of its contenders.

use crate::comparison::Table;
use crate::{
    browser, cell, crossing, memory, rate, report, rows, step, stream, tick, virtual_time,
};

text::choice!(
    /// A table of contenders.
    Group, "table", {
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
