//! How the server keeps its own sample time: Figure 7.

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
];

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
