//! The step responses, and what a fault does to one: Figures 5 and 6, and the text.

use analysis::{LoopVerdict, Run};

use super::evidence::Evidence;
use super::metric::Metric;
use super::row::{Judged, Weight};
use super::source::Source;
use report::group::Estimate;
use report::number::number;

pub(super) const FIGURES: &[Metric] = &[
    Metric::group("share of runs that end stable", "", |source| {
        let (stable, n) = ended(source, LoopVerdict::Holds);
        Ok(Estimate::share(stable, n))
    }),
    Metric::group("runs that grow", "", |source| {
        let (grown, n) = ended(source, LoopVerdict::Lost);
        Ok((n > 0).then(|| Estimate::exact(grown as f64, n)))
    }),
    Metric::group("final value", "", |source| {
        let last = |run: &Run| run.metrics.as_ref()?.response?.final_value;
        Ok(source.group.median_or_never(last))
    }),
    Metric::group("back after the fault", "ms", |source| {
        let back = |run: &Run| run.recovery.as_ref()?.back_ms;
        Ok(source.group.median_or_never(back))
    }),
];

/// The number of runs with this verdict, and of all runs.
fn ended(source: &Source<'_>, so: LoopVerdict) -> (u64, u64) {
    let runs = &source.group.runs;
    let verdicts = runs
        .iter()
        .filter_map(|run| Some(run.metrics.as_ref()?.response?.verdict));
    let n = verdicts.filter(|verdict| *verdict == so).count();
    (n as u64, runs.len() as u64)
}

pub(super) fn note_unsettled(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for Judged { source, .. } in judged {
        let (unsettled, n) = ended(source, LoopVerdict::Unsettled);
        if unsettled > 0 {
            evidence.note(format!(
                "{unsettled} of {n} runs of {} had not settled when they ended.",
                source.label()
            ));
        }
    }
}

/// Records small groups behind the numbers that decide, and behind those that they are computed from.
pub(super) fn few(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for judged in judged
        .iter()
        .filter(|judged| judged.row.weight != Weight::Beside)
    {
        evidence.few(&judged.source);
    }
}

/// Explains the pace: a client that advances its integrator by h per request is slower by the ratio
/// of its interval to h.
pub(super) fn explain_pace(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    few(evidence, judged);
    let Some(Judged { source, .. }) = judged.first() else {
        return;
    };
    let interval = |run: &Run| run.metrics.as_ref()?.arrivals.interval_avg_ms;
    if let Some(interval_ms) = source.group.median(interval) {
        evidence.explain(format!(
            "Its commands come every {} ms, and it integrates {} ms with each; ten times the settling \
             takes about 10.5 ms.",
            number(interval_ms.value),
            number(source.h_s() * 1e3)
        ));
    }
}
