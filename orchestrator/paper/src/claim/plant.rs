//! How the server keeps its own sample time, and what it costs the loop where it does not: Figure 7 and section 4.3.

use std::ops::ControlFlow;

use analysis::Run;
use endpoint::TickRow;
use record::{ReadError, rows};

use super::evidence::Evidence;
use super::metric::Metric;
use super::rare::Count;
use super::row::Judged;
use super::together::in_10_ms;
use report::number::number;

pub(super) const FIGURES: &[Metric] = &[
    Metric::median("mean of the sample intervals", "ms", |m| {
        m.ticks.interval_avg_ms
    }),
    Metric::median("sd of the sample intervals", "ms", |m| {
        m.ticks.interval_sd_ms
    }),
    Metric::group(
        "share of sample intervals that are zero or negative",
        "",
        |source| {
            let count = Count::over(source, |m| (m.ticks.interval_nonpositive, m.ticks.count));
            Ok(count.and_then(Count::sampled))
        },
    ),
    Metric::group(
        "share of messages in the same 10 ms as the one before",
        "",
        |source| Ok(in_10_ms(source).and_then(Count::sampled)),
    ),
    Metric::group("IAE from the first command on", "s", |source| {
        source.group.try_median(iae_from_command)
    }),
];

/// The integral of the absolute error from the tick on that took the first command, in units of y times s.
///
/// A plant whose ticks are late takes its first command at a tick that was due before it was sent, so that its step
/// begins earlier by the plant's time. From that tick on, two plants are compared that have the same step before them.
pub(crate) fn iae_from_command(run: &Run) -> Result<Option<f64>, ReadError> {
    let iae = |run: &Run| run.metrics.as_ref()?.response?.iae;
    let Some(iae) = iae(run) else {
        return Ok(None);
    };
    let (lasts_ns, settings) = (run.lasts_ns(), &run.cell.settings);
    // What was commanded before the first deadline is no command of the run.
    let (mut earlier, mut open) = (None, 0.0);
    rows::read_while(&run.folder.join(TickRow::FILE), |row: &TickRow| {
        if row.t_due_ns < lasts_ns.start {
            earlier = row.seq;
        } else if row.seq == earlier {
            open += (settings.r - row.y).abs() * settings.h.seconds();
        } else {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    })?;
    Ok(Some(iae - open))
}

pub(super) fn note_spread(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for judged in judged {
        let ours = judged.ours.filter(|sd| sd.value > 0.0);
        if let (Some(paper), Some(ours)) = (judged.row.paper, ours) {
            evidence.note(format!(
                "At h = {} ms the paper's desktop has {} times the spread.",
                number(judged.source.h_s() * 1e3),
                number(paper / ours.value)
            ));
        }
    }
}
