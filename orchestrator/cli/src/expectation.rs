//! What is expected of runs: asked of them today, and what became of it in print.

use std::io::Write;

use analysis::expect::{Judgement, judge_rows};
use analysis::outline::Outlined;
use plan::{Clause, Day, Plan};

/// Asks runs what is expected of them today.
pub(crate) fn judged(plan: &Plan, rows: &[&Outlined], required: &[Clause]) -> Judgement {
    let now = jiff::Timestamp::now().to_zoned(jiff::tz::TimeZone::UTC);
    judge_rows(plan, rows, required, Day::from(now.date()))
}

/// Prints whether the runs show what is expected: a line for each clause and group that it is asked of.
pub(crate) fn print(judgement: &Judgement, out: &mut impl Write) -> std::io::Result<()> {
    if judgement.is_empty() {
        return Ok(());
    }
    write!(out, "\n{judgement}")
}
