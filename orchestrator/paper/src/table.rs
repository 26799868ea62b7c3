//! The paper's tables, recomputed, with the paper's numbers beside ours.

mod machine;
mod ping;
mod zero;

use analysis::Campaign;
use report::table::Table;

/// Tables 1 to 3, in order.
#[must_use]
pub fn all(campaign: &Campaign) -> Vec<Table> {
    vec![
        machine::table(campaign),
        ping::table(campaign),
        zero::table(campaign),
    ]
}
