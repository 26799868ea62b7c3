//! The receiver of a simulated run's rows, as the run goes on.

use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use link::Way;

use crate::echo::Echo;

/// Receives rows in the order in which a real run would write them.
pub trait Record {
    /// The plant has ticked.
    fn tick(&mut self, row: &TickRow);

    /// The second input and output of that tick, of a plant that has one of them.
    fn second(&mut self, row: &SecondRow) {
        let _ = row;
    }

    /// A command has reached the plant.
    fn arrival(&mut self, row: &ArrivalRow) {
        let _ = row;
    }

    /// A deadline was missed, or its message has ended.
    fn message(&mut self, row: &MessageRow) {
        let _ = row;
    }

    /// An echo of the series with this number in [`Setup::echoes`](crate::Setup::echoes) is back, or
    /// lost.
    fn echo(&mut self, series: usize, echo: &Echo) {
        let _ = (series, echo);
    }

    /// A packet of `bytes` (IP length) enters the link at `t_ns`, whether it is lost or not. Called only for
    /// links with a rate limit on either way, from link time 0 on, in order of entry for each way.
    fn packet(&mut self, way: Way, t_ns: u64, bytes: u32) {
        let _ = (way, t_ns, bytes);
    }
}
