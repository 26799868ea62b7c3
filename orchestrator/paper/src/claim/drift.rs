//! Whether messages keep their schedule in open loop: Figures 3 and 4.

use record::ReadError;

use super::evidence::Evidence;
use super::metric::Metric;
use super::row::Judged;
use super::slope::{Residuals, Series};
use super::source::Source;
use report::claim::Verdict;
use report::group::Estimate;
use report::number::number;

/// By how much the quartz clocks of two computers may differ: what their makers allow, 50 millionths.
const APART: f64 = 50e-6;

pub(super) const FIGURES: &[Metric] = &[
    Metric::group("slope", "s/s", |source| slope(source, |series| series)),
    Metric::group("slope, with clocks 50 ppm apart", "s/s", |source| {
        slope(source, |series| series.by_another_clock(APART))
    }),
    Metric::group("median distance from the line", "ms", |source| {
        Ok(residuals(source)?.map(|about| Estimate::exact(about.p50_ms, about.n)))
    }),
    Metric::group(
        "median distance from the line, in sample times",
        "",
        |source| {
            let in_h =
                |about: Residuals| Estimate::exact(about.p50_ms / 1e3 / source.h_s(), about.n);
            Ok(residuals(source)?.map(in_h))
        },
    ),
    Metric::group("share of messages off the line", "", |source| {
        let share = |about: Residuals| {
            let share = analysis::statistics::share(about.off, about.n)?;
            Some(Estimate::exact(share, about.n))
        };
        Ok(residuals(source)?.and_then(share))
    }),
    Metric::group("messages in a row off the line", "", |source| {
        Ok(residuals(source)?.map(|about| Estimate::exact(about.longest as f64, about.n)))
    }),
];

/// The slope of a group: the mean over its runs, whose errors are taken as independent.
fn slope(source: &Source<'_>, of: fn(Series) -> Series) -> Result<Option<Estimate>, ReadError> {
    let mut slopes = Vec::new();
    for run in &source.group.runs {
        slopes.extend(of(Series::read(run)?).least_squares());
    }
    let n = slopes.len() as f64;
    let value = slopes.iter().map(|slope| slope.value).sum::<f64>() / n;
    let squares: f64 = slopes
        .iter()
        .map(|slope| (slope.high - slope.value).powi(2))
        .sum();
    let messages = slopes.iter().map(|slope| slope.n).sum();
    let whole = Estimate::around(value, squares.sqrt() / n, messages);
    Ok((!slopes.is_empty()).then_some(whole))
}

/// The residuals about the line of a group's first run.
fn residuals(source: &Source<'_>) -> Result<Option<Residuals>, ReadError> {
    let Some(run) = source.group.runs.first() else {
        return Ok(None);
    };
    Ok(Series::read(run)?.residuals())
}

pub(super) fn note_tilts(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for Judged {
        source,
        ours,
        verdict,
        ..
    } in judged
    {
        let tilted = ours.filter(|_| *verdict != Verdict::Agrees);
        let (Some(ours), Some(run)) = (tilted, source.group.runs.first()) else {
            continue;
        };
        // The rows could be read a moment ago. If not now, only this sentence is missing.
        let middle = Series::read(run).ok().and_then(|series| series.resistant());
        let middle = middle.map_or_else(String::new, |slope| {
            format!(
                "; what is regular in it has {} s/s (Tukey's resistant line)",
                number(slope)
            )
        });
        evidence.note(format!(
            "Stalls tilt the line of {}, whose slope is only known to lie between {} and {} \
             s/s{middle}.",
            source.label(),
            number(ours.low),
            number(ours.high)
        ));
    }
}

/// Rows come in pairs: the messages in a row off the line, and the slope.
pub(super) fn explain_flat(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    let still: Vec<String> = judged
        .chunks_exact(2)
        .filter(|pair| pair[0].verdict == Verdict::Differs)
        .filter_map(|pair| {
            let slope = number(pair[1].ours?.value);
            Some(format!("{slope} s/s on {}", pair[1].row.asked.topology))
        })
        .collect();
    if !still.is_empty() {
        evidence.explain(format!(
            "Today's Python keeps 100 Hz on a machine and a link that do: its slope is {}.",
            still.join(", ")
        ));
    }
}
