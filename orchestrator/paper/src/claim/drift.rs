//! Whether messages keep their schedule in open loop: Figures 3 and 4.

use analysis::ReadError;
use analysis::lateness::{IMPULSE, IMPULSE_MS};

use super::evidence::{Evidence, Source};
use super::row::{Accepted, Claim, Judged, Metric, NEAR, Row, Than};
use super::slope::{Residuals, Series};
use super::words::fraction;
use crate::printed;
use crate::subject::Asked;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, PYTHON, Subject};
use report::claim::Verdict;
use report::claim::rule::ANY;
use report::group::Estimate;
use report::number::{number, spelled};

/// A slope below this, s/s, is flat: a third of a second in five minutes.
const FLAT: f64 = 1e-3;
/// The slope of a client that drifts is this many times that of one that does not.
const STEEPER: f64 = 10.0;
/// Greatest median residual at 10 Hz, ms: a tenth of h.
const RETURNS_MS: f64 = 10.0;
/// Greatest share of messages that may be off a line and still count as impulses.
const FEW: f64 = 0.2;
/// This many messages in a row off the line are a step: a tenth of a second at 100 Hz.
const STEP: f64 = 10.0;

const SLOPE: Metric = Metric::group("slope", "s/s", slope);
/// The limit that a slope has to exceed, from the slope of a client that should be flat.
const STEEP: Metric = Metric::group("slope that is steep", "s/s", |source| {
    Ok(slope(source)?.map(steep))
});
const DISTANCE: Metric = Metric::group("median distance from the line", "ms", |source| {
    Ok(residuals(source)?.map(|about| Estimate::exact(about.p50_ms, about.n)))
});
const OFF_LINE: Metric = Metric::group("share of messages off the line", "", |source| {
    let share = |about: Residuals| {
        let share = analysis::statistics::share(about.off, about.n)?;
        Some(Estimate::exact(share, about.n))
    };
    Ok(residuals(source)?.and_then(share))
});
const IN_A_ROW: Metric = Metric::group("messages in a row off the line", "", |source| {
    Ok(residuals(source)?.map(|about| Estimate::exact(about.longest as f64, about.n)))
});

/// Figure 3: both clients at 3.3 and 10 Hz.
pub(super) fn figure_3() -> Vec<Claim> {
    let slow = [printed::H_3_HZ_NS, printed::H_10_HZ_NS];
    let at = |h_ns| NEAR.map(|topology| PYTHON.open(topology, h_ns));
    let flat = |asked| Row::new(asked, SLOPE, (-FLAT, FLAT)).paper(0.0);
    let impulses = |asked| {
        [
            Row::new(asked, DISTANCE, (0.0, RETURNS_MS)),
            Row::new(asked, OFF_LINE, (0.0, FEW)),
        ]
    };
    vec![
        Claim {
            id: "fig-3-python-flat",
            place: "Fig 3",
            claim: "Python at 3.3 and 10 Hz keeps the schedule on arima, buccoo and couva: no slope.",
            check: format!("the least-squares slope of lateness is within {FLAT} s/s"),
            rows: slow.into_iter().flat_map(at).map(flat).collect(),
            remark: Some(note_tilts),
            ..Claim::default()
        },
        drifts(
            "fig-3-javascript-drifts",
            "Fig 3",
            "JavaScript at 3.3 and 10 Hz falls behind steadily on all three.",
            &slow,
        ),
        Claim {
            id: "fig-3-impulses",
            place: "Fig 3",
            claim: "Python's errors at 10 Hz are impulses: the series returns to its line.",
            check: format!(
                "half of the messages lie within {RETURNS_MS} ms of the resistant line, and at most {} \
                 are off it (by more than {} medians and {IMPULSE_MS} ms)",
                fraction(FEW),
                spelled(IMPULSE)
            ),
            rows: at(printed::H_10_HZ_NS)
                .into_iter()
                .flat_map(impulses)
                .collect(),
            ..Claim::default()
        },
    ]
}

/// Figure 4: both clients at 100 Hz.
pub(super) fn figure_4() -> Vec<Claim> {
    let steps = |topology| {
        let asked = PYTHON.open(topology, printed::H_100_HZ_NS);
        // Without steps the slope decides: in the paper it is not flat.
        let accepted = Accepted::WithinOrBeyond((STEP, f64::INFINITY), SLOPE, (-FLAT, FLAT));
        [
            Row::new(asked, IN_A_ROW, accepted),
            Row::shown(asked, SLOPE),
        ]
    };
    vec![
        drifts(
            "fig-4-javascript-diverges",
            "Fig 4",
            "At 100 Hz JavaScript diverges on all three.",
            &[printed::H_100_HZ_NS],
        ),
        Claim {
            id: "fig-4-python-not-flat",
            place: "Fig 4",
            claim: "At 100 Hz Python's series is no longer flat either: it has a slope, or steps.",
            check: format!(
                "{} or more messages in a row are off the line (a step of {} of a second), or the \
                 slope's 95 % interval lies beyond {FLAT} s/s",
                spelled(STEP),
                fraction(STEP * printed::H_100_HZ_NS as f64 / 1e9)
            ),
            rows: NEAR.into_iter().flat_map(steps).collect(),
            remark: Some(explain_flat),
            ..Claim::default()
        },
    ]
}

/// The claim that JavaScript is steeper than Python at these rates, on the three near positions.
fn drifts(id: &'static str, place: &'static str, claim: &'static str, rates_ns: &[u64]) -> Claim {
    let at = |h_ns: &u64| NEAR.map(|topology| (topology, *h_ns));
    let rows = rates_ns.iter().flat_map(at).flat_map(|(topology, h_ns)| {
        let above = Accepted::Above(Than {
            asked: PYTHON.open(topology, h_ns),
            metric: STEEP,
            unknown: ANY,
        });
        let row = |subject: Subject| Row::new(subject.open(topology, h_ns), SLOPE, above);
        [row(FIREFOX_2011), row(CHROMIUM_2011).beside()]
    });
    Claim {
        id,
        place,
        claim,
        check: format!(
            "the slope is above {FLAT} s/s and more than {} times Python's",
            spelled(STEEPER)
        ),
        rows: rows.collect(),
        ..Claim::default()
    }
}

/// The slope of a group: the mean over its runs, whose errors are taken as independent.
fn slope(source: &Source<'_>) -> Result<Option<Estimate>, ReadError> {
    let mut slopes = Vec::new();
    for run in &source.group.runs {
        slopes.extend(Series::read(run)?.least_squares());
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

/// The limit that a slope has to exceed, with the uncertainty of the slope that should be flat.
fn steep(flat: Estimate) -> Estimate {
    let least = |slope: f64| FLAT.max(STEEPER * slope.abs());
    let (a, b) = (least(flat.low), least(flat.high));
    let has_zero = flat.low <= 0.0 && flat.high >= 0.0;
    Estimate {
        value: least(flat.value),
        low: if has_zero { FLAT } else { a.min(b) },
        high: a.max(b),
        n: flat.n,
    }
}

/// The residuals about the line of a group's first run.
fn residuals(source: &Source<'_>) -> Result<Option<Residuals>, ReadError> {
    let Some(run) = source.group.runs.first() else {
        return Ok(None);
    };
    Ok(Series::read(run)?.residuals())
}

fn note_tilts(evidence: &mut Evidence, judged: &[Judged<'_>]) {
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
fn explain_flat(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    let still: Vec<String> = judged
        .chunks_exact(2)
        .filter(|pair| pair[0].verdict == Verdict::Differs)
        .filter_map(|pair| {
            let Asked { topology, .. } = pair[1].row.asked;
            Some(format!("{} s/s on {topology}", number(pair[1].ours?.value)))
        })
        .collect();
    if !still.is_empty() {
        evidence.explain(format!(
            "Today's Python keeps 100 Hz on a machine and a link that do: its slope is {}.",
            still.join(", ")
        ));
    }
}
