//! Who takes the rows of a simulated run, as it goes.

use endpoint::{ArrivalRow, MessageRow, TickRow};

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
}
