//! Who takes the rows of a simulated run, as it goes.

use endpoint::{ArrivalRow, MessageRow, TickRow};
use link::Way;

use crate::echo::Echo;

/// Takes rows, in the order in which a real run would write them.
pub trait Record {
    /// The plant has ticked.
    fn tick(&mut self, row: &TickRow);

    /// A command has reached the plant.
    fn arrival(&mut self, row: &ArrivalRow) {
        let _ = row;
    }

    /// A deadline is over, or its message has ended.
    fn message(&mut self, row: &MessageRow) {
        let _ = row;
    }

    /// An echo of the series with this number in [`Setup::echoes`](crate::Setup::echoes) is back, or
    /// lost.
    fn echo(&mut self, series: usize, echo: &Echo) {
        let _ = (series, echo);
    }

    /// A packet of `bytes` (of IP) enters the link at `t_ns`, whatever becomes of it. Called for links
    /// with a rate limit on either way and from link time 0 on, in order of entry for each way.
    fn packet(&mut self, way: Way, t_ns: u64, bytes: u32) {
        let _ = (way, t_ns, bytes);
    }
}
