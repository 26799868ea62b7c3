//! How the intervals between commands are distributed, and whether two groups differ in it.

use analysis::{ReadError, Run, rows};
use endpoint::ArrivalRow;

use super::evidence::Source;
use super::{Limits, Part};
use crate::group::Estimate;

/// An interval is at a multiple of h, or zero, within a tenth of h. Of intervals that fall
/// anywhere a fifth are.
const NEAR: i128 = 10;
pub(super) const AT_H: &str = "share of intervals at h";
pub(super) const ZERO: &str = "share of intervals below h/10";
pub(super) const ZERO_TICK: &str = "share of commands in the same tick as the one before";

/// How the intervals of a run are distributed, as shares of all of them.
#[derive(Debug, Default)]
struct Spacing {
    count: u64,
    /// Within a tenth of h of a multiple of h from h on.
    multiple: u64,
    /// Less than a tenth of h.
    zero: u64,
}

impl Spacing {
    fn read(run: &Run) -> Result<Spacing, ReadError> {
        let h_ns = i128::from(run.cell.settings.h.ns());
        let mut spacing = Spacing::default();
        let mut last_ns = None;
        let path = run.folder.join("arrivals.csv");
        rows::read(&path, ArrivalRow::COLUMNS, |row: &ArrivalRow| {
            let t_ns = i128::from(row.t_arrive_ns);
            let Some(last_ns) = last_ns.replace(t_ns) else {
                return;
            };
            let interval_ns = t_ns - last_ns;
            let off_ns = (interval_ns + h_ns / 2).rem_euclid(h_ns) - h_ns / 2;
            spacing.count += 1;
            if interval_ns * NEAR < h_ns {
                spacing.zero += 1;
            } else if off_ns.abs() * NEAR <= h_ns {
                spacing.multiple += 1;
            }
        })?;
        Ok(spacing)
    }
}

/// What the intervals of a group come to, each a median over its runs.
pub(super) struct Histogram<'a> {
    pub(super) source: Source<'a>,
    pub(super) at_h: Option<Estimate>,
    pub(super) multiple: Option<Estimate>,
    pub(super) zero: Option<Estimate>,
    pub(super) zero_tick: Option<Estimate>,
}

impl<'a> Histogram<'a> {
    pub(super) fn read(source: Source<'a>) -> Result<Self, ReadError> {
        let runs = source.group.runs.iter().map(|run| Spacing::read(run));
        let spacings = runs.collect::<Result<Vec<_>, _>>()?;
        let shares = |part: fn(&Spacing) -> u64| {
            let share = |spacing| analysis::statistics::share(part(spacing), spacing.count);
            let shares: Vec<f64> = spacings.iter().filter_map(share).collect();
            Estimate::median(&shares)
        };
        Ok(Histogram {
            at_h: source.median(|run| run.metrics.as_ref()?.arrivals.interval_at_h),
            zero_tick: source.median(|run| run.metrics.as_ref()?.arrivals.zero_tick),
            multiple: shares(|spacing| spacing.multiple),
            zero: shares(|spacing| spacing.zero),
            source,
        })
    }

    pub(super) fn part(
        &self,
        quantity: &str,
        ours: Option<Estimate>,
        limits: impl Into<Limits>,
    ) -> Part {
        Part::judged(self.source.name(quantity), "", None, ours, limits)
    }

    /// A share that is to be above or below another's, which was measured too.
    pub(super) fn beside(
        &self,
        quantity: &str,
        ours: Option<Estimate>,
        other: Option<Estimate>,
        limits: fn(Estimate) -> Limits,
    ) -> Part {
        match other {
            Some(other) => self.part(quantity, ours, limits(other)),
            None => self.part(quantity, None, (0.0, 1.0)),
        }
    }
}
