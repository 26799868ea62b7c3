//! The time constant that the text gives its motor: section 4.3. It is asked of no run, but of the paper's own transfer
//! function.

use super::evidence::Evidence;
use crate::printed::{POLES, TIME_CONSTANT_MS};
use report::claim::Part;
use report::group::Estimate;
use report::number::number;

/// Part of the paper's number by which ours may differ.
pub(super) const WITHIN: f64 = 0.1;

/// Holds the time constant of the faster pole against the text's.
pub(super) fn of_the_motor() -> Evidence {
    let mut evidence = Evidence::default();
    let [fast_ms, slow_ms] = POLES.map(|pole| -1e3 / pole);
    let around = |share: f64| TIME_CONSTANT_MS * share;
    evidence.decide(Part::judged(
        "time constant of the faster pole",
        "ms",
        Some(TIME_CONSTANT_MS),
        Some(Estimate::exact(fast_ms, 1)),
        (around(1.0 - WITHIN), around(1.0 + WITHIN)),
    ));
    evidence.explain(format!(
        "The transfer function has poles at {} and {} 1/s, time constants of {} and {} ms; the slower one leads.",
        number(POLES[0]),
        number(POLES[1]),
        number(fast_ms),
        number(slow_ms)
    ));
    evidence
}
