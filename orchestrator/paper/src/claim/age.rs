//! How old what steers the plant is: section 4.1.

use analysis::Run;
use analysis::budget::{Budget, Sample};
use analysis::statistics::upper_median;
use record::ReadError;

use super::metric::Metric;

pub(super) const FIGURES: &[Metric] = &[Metric::group(
    "from a measurement to the effect of its command",
    "ms",
    |source| source.group.try_median(from_measurement_ms),
)];

/// From the tick at which y was measured to the tick at which the u that follows from it took effect: the median over a
/// run's samples, ms.
pub(crate) fn from_measurement_ms(run: &Run) -> Result<Option<f64>, ReadError> {
    // The sum needs no link: only its parts do.
    let budget = Budget::through(run, None)?;
    let mut all_ns: Vec<i64> = budget.samples.iter().map(Sample::total_ns).collect();
    Ok(upper_median(&mut all_ns, Ord::cmp).map(|ns| ns as f64 * 1e-6))
}
