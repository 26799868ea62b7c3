//! The time between control commands: Figures 8 and 9.

use analysis::Run;
use endpoint::{ArrivalRow, TickRow};
use plan::file_name;

use super::evidence::Evidence;
use super::metric::Metric;
use super::rare::Count;
use super::row::Judged;
use super::source::Source;
use crate::printed;
use record::{ReadError, rows};
use report::group::Estimate;
use report::number::number;

/// An interval is at a multiple of h, or zero, if it is within h divided by this. Of evenly spread
/// intervals a fifth are.
pub(super) const NEAR: i128 = 10;

const EVERY_H: &str = "Here the client sends every h whatever is outstanding, and the link keeps the \
                       order of packets: the intervals at the plant are h but for what changes the \
                       delay between two packets.";

pub(super) const FIGURES: &[Metric] = &[
    Metric::median("share of intervals at h", "", |m| m.arrivals.interval_at_h),
    Metric::group("share of intervals at a multiple of h", "", |source| {
        share(source, Spacing::of_arrivals, |spacing| spacing.multiple)
    }),
    Metric::group("share of intervals below h/10", "", |source| {
        share(source, Spacing::of_arrivals, |spacing| spacing.zero)
    }),
    Metric::median(
        "share of commands in the same tick as the one before",
        "",
        |m| m.arrivals.zero_tick,
    ),
    // Counted over all runs of the group, since the question is whether there are any at all.
    Metric::group(
        "commands in the same tick as the one before",
        "",
        |source| {
            let count = Count::over(source, |m| (m.arrivals.zero_tick, m.arrivals.count));
            Ok(count.map(|count| Estimate::exact(count.found as f64, count.of)))
        },
    ),
    Metric::median("share of messages out of order", "", |m| {
        analysis::statistics::share(m.arrivals.out_of_order, m.arrivals.count)
    }),
    Metric::median("mean control interval", "ms", |m| {
        m.arrivals.interval_avg_ms
    }),
    Metric::median("sd of the control intervals", "ms", |m| {
        m.arrivals.interval_sd_ms
    }),
    Metric::median("median round trip of a message", "ms", |m| {
        m.messages.rtt.p50_ms
    }),
    Metric::median("least round trip of a message", "ms", |m| {
        m.messages.rtt_min_ms
    }),
    Metric::group(
        "share of intervals at h, by the stamps of ticks",
        "",
        |source| share(source, Spacing::of_ticks, |spacing| spacing.at_h),
    ),
    Metric::group(
        "share of intervals below h/10, by the stamps of ticks",
        "",
        |source| share(source, Spacing::of_ticks, |spacing| spacing.zero),
    ),
    Metric::median(
        "share of intervals at h, by the stamps of arrivals",
        "",
        |m| m.arrivals.interval_at_h,
    ),
];

/// Passes each arrival of a run except the first to `each`, after the one before it.
pub(super) fn neighbours(
    run: &Run,
    mut each: impl FnMut(&ArrivalRow, &ArrivalRow),
) -> Result<(), ReadError> {
    let (mut last, path) = (None, run.folder.join("arrivals.csv"));
    rows::read(&path, |row: &ArrivalRow| {
        if let Some(last) = last.replace(*row) {
            each(&last, row);
        }
    })?;
    Ok(())
}

/// Counts of the intervals of a run.
#[derive(Debug, Default)]
struct Spacing {
    count: u64,
    /// Those within h/10 of h.
    at_h: u64,
    /// Those within h/10 of a multiple of h, from h on.
    multiple: u64,
    /// Those below h/10.
    zero: u64,
}

impl Spacing {
    fn push(&mut self, h_ns: u64, from_ns: u64, to_ns: u64) {
        let h_ns = i128::from(h_ns);
        let interval_ns = i128::from(to_ns) - i128::from(from_ns);
        let off_ns = (interval_ns + h_ns / 2).rem_euclid(h_ns) - h_ns / 2;
        self.count += 1;
        self.at_h += u64::from((interval_ns - h_ns).abs() * NEAR <= h_ns);
        if interval_ns * NEAR < h_ns {
            self.zero += 1;
        } else if off_ns.abs() * NEAR <= h_ns {
            self.multiple += 1;
        }
    }

    /// By the times at which commands arrived.
    fn of_arrivals(run: &Run) -> Result<Spacing, ReadError> {
        let (mut spacing, h_ns) = (Spacing::default(), run.cell.settings.h.ns());
        neighbours(run, |last, row| {
            spacing.push(h_ns, last.t_arrive_ns, row.t_arrive_ns);
        })?;
        Ok(spacing)
    }

    /// By the timestamps of ticks: the time of a command is that of the first tick after its arrival.
    fn of_ticks(run: &Run) -> Result<Spacing, ReadError> {
        let (mut spacing, h_ns) = (Spacing::default(), run.cell.settings.h.ns());
        let mut ticks_ns = Vec::new();
        let path = run.folder.join(file_name::TICKS);
        rows::read(&path, |row: &TickRow| {
            ticks_ns.push(row.t_tick_ns);
        })?;
        let mut last_ns = None;
        let path = run.folder.join(file_name::ARRIVALS);
        rows::read(&path, |row: &ArrivalRow| {
            let tick = usize::try_from(row.tick).ok();
            let next = tick.and_then(|tick| ticks_ns.get(tick.checked_add(1)?));
            if let Some(stamp_ns) = next
                && let Some(last_ns) = last_ns.replace(*stamp_ns)
            {
                spacing.push(h_ns, last_ns, *stamp_ns);
            }
        })?;
        Ok(spacing)
    }
}

/// The median over the runs of the share that `part` is of all intervals.
fn share(
    source: &Source<'_>,
    of: fn(&Run) -> Result<Spacing, ReadError>,
    part: fn(&Spacing) -> u64,
) -> Result<Option<Estimate>, ReadError> {
    let mut shares = Vec::new();
    for run in &source.group.runs {
        let spacing = of(run)?;
        shares.extend(analysis::statistics::share(part(&spacing), spacing.count));
    }
    Ok(Estimate::median(&shares))
}

/// The first two rows are arima's.
pub(super) fn note_phase(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    evidence.explain(EVERY_H);
    let [zero, tick, ..] = judged else { return };
    let tick = tick.ours.filter(Estimate::has_interval);
    if let (Some(zero), Some(tick)) = (zero.ours, tick) {
        evidence.note(format!(
            "On arima {} of the intervals are below h/10, and {} to {} of the commands share a \
             tick: commands and ticks have one period, so this depends on the phase that a run \
             happens to have.",
            number(zero.value),
            number(tick.low),
            number(tick.high)
        ));
    }
}

pub(super) fn explain_order(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    evidence.explain(EVERY_H);
    let Some(Judged { source: vpn, .. }) = judged.first() else {
        return;
    };
    let sd_ms = vpn
        .group
        .median(|run| run.metrics.as_ref()?.ticks.interval_sd_ms);
    let paper = printed::FIG_7.iter().find(|of| of.h_ns == vpn.asked.h_ns);
    if let (Some(ours), Some(paper)) = (sd_ms, paper) {
        evidence.explain(format!(
            "The paper's server itself was off by {} ms (sd), as wide as h; ours by {} ms.",
            number(paper.sd_ms),
            number(ours.value)
        ));
    }
}

/// The third row is arima's share at h.
pub(super) fn note_peaks(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    if let Some(at_h) = judged.get(2).and_then(|judged| judged.ours) {
        evidence.note(format!(
            "By the same stamps {} of the intervals on arima are at h, where Figure 8a has peaks: \
             this plant changes both figures alike, so they cannot both come out at once.",
            number(at_h.value)
        ));
    }
}
