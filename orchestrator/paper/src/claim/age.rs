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

/// The median over a run's samples, ms.
fn from_measurement_ms(run: &Run) -> Result<Option<f64>, ReadError> {
    // The sum needs no link: only its parts do.
    let budget = Budget::through(run, None)?;
    let mut all_ns: Vec<i64> = budget.samples.iter().map(Sample::total_ns).collect();
    Ok(upper_median(&mut all_ns, Ord::cmp).map(|ns| ns as f64 * 1e-6))
}
