//! Whether messages keep their schedule in open loop: Figures 3 and 4.

use analysis::{Campaign, ReadError};

use super::evidence::{CHROMIUM, Claim, Evidence, FIREFOX, NEAR, PYTHON, Source, Who};
use super::rule::{ANY, judge};
use super::slope::{Residuals, Series};
use super::words::number;
use super::{Finding, Limits, Part, Verdict};
use crate::group::Estimate;
use crate::paper;

/// A slope of less, s/s, is flat: a third of a second in five minutes.
const FLAT: f64 = 1e-3;
/// A client that drifts does so by so many times the slope of one that does not.
const STEEPER: f64 = 10.0;
/// What a residual at 10 Hz may be in the median, ms: a tenth of h.
const RETURNS_MS: f64 = 10.0;
/// The greatest share of messages that can be off a line and still be impulses on it.
const FEW: f64 = 0.2;
/// So many messages in a row off the line are a step of a tenth of a second at 100 Hz.
const STEP: u64 = 10;

/// Figures 3 and 4: the slopes of both clients at three rates, and what is left about the line.
pub(super) fn figures_3_and_4(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let slow = [paper::H_3_HZ_NS, paper::H_10_HZ_NS];
    let fast = [paper::H_100_HZ_NS];
    Ok(vec![
        python_is_flat(campaign, &slow)?.on(Claim {
            id: "fig-3-python-flat",
            place: "Fig 3",
            claim: "Python at 3.3 and 10 Hz keeps the schedule on arima, buccoo and couva: no slope.",
            check: "the least-squares slope of lateness is within 0.001 s/s",
        }),
        javascript_drifts(campaign, &slow)?.on(Claim {
            id: "fig-3-javascript-drifts",
            place: "Fig 3",
            claim: "JavaScript at 3.3 and 10 Hz falls behind steadily on all three.",
            check: "the slope is above 0.001 s/s and more than ten times Python's",
        }),
        impulses(campaign)?,
        javascript_drifts(campaign, &fast)?.on(Claim {
            id: "fig-4-javascript-diverges",
            place: "Fig 4",
            claim: "At 100 Hz JavaScript diverges on all three.",
            check: "the slope is above 0.001 s/s and more than ten times Python's",
        }),
        python_is_not_flat(campaign)?,
    ])
}

/// The slopes of a group: the mean over its runs, their errors as independent.
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

fn python_is_flat(campaign: &Campaign, rates_ns: &[u64]) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    for h_ns in rates_ns {
        for topology in NEAR {
            let python = Source::open(campaign, PYTHON, topology, *h_ns);
            evidence.ask(&python);
            let ours = slope(&python)?;
            let part = Part::judged(python.name("slope"), "s/s", Some(0.0), ours, (-FLAT, FLAT));
            let tilted = ours.filter(|_| part.verdict != Verdict::Agrees);
            if let (Some(ours), Some(run)) = (tilted, python.group.runs.first()) {
                let middle = Series::read(run)?.resistant();
                evidence.note(tilt(&python, ours, middle));
            }
            evidence.decide(part);
        }
    }
    Ok(evidence)
}

fn tilt(source: &Source<'_>, ours: Estimate, middle: Option<f64>) -> String {
    let middle = middle.map_or_else(String::new, |slope| {
        format!(
            "; what is regular in it has {} s/s (Tukey's resistant line)",
            number(slope)
        )
    });
    format!(
        "Stalls tilt the line of {}, whose slope is only known to be {} to {} s/s{middle}.",
        source.label(),
        number(ours.low),
        number(ours.high)
    )
}

fn javascript_drifts(campaign: &Campaign, rates_ns: &[u64]) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    for h_ns in rates_ns {
        for topology in NEAR {
            let python = Source::open(campaign, PYTHON, topology, *h_ns);
            evidence.ask(&python);
            let least = slope(&python)?.map(steep);
            let part = |who: Who| -> Result<(Source<'_>, Part), ReadError> {
                let source = Source::open(campaign, who, topology, *h_ns);
                let ours = slope(&source)?;
                // Without Python there is nothing to be ten times as steep as.
                let limits = least.map_or(Limits::from(ANY), Limits::above);
                let ours = least.and(ours);
                let part = Part::judged(source.name("slope"), "s/s", None, ours, limits);
                Ok((source, part))
            };
            let (firefox, decides) = part(FIREFOX)?;
            evidence.ask(&firefox);
            evidence.decide(decides);
            let (chromium, beside) = part(CHROMIUM)?;
            evidence.ask_beside(&chromium);
            evidence.show(beside);
        }
    }
    Ok(evidence)
}

/// What a slope has to be above beside one that ought to be flat: as sure as that one is known.
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

fn impulses(campaign: &Campaign) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    for topology in NEAR {
        let source = Source::open(campaign, PYTHON, topology, paper::H_10_HZ_NS);
        evidence.ask(&source);
        let about = residuals(&source)?;
        let median = about.map(|about| Estimate::exact(about.p50_ms, about.n));
        let off = about.and_then(|about| {
            let share = analysis::statistics::share(about.off, about.n)?;
            Some(Estimate::exact(share, about.n))
        });
        evidence.decide(Part::judged(
            source.name("median distance from the line"),
            "ms",
            None,
            median,
            (0.0, RETURNS_MS),
        ));
        evidence.decide(Part::judged(
            source.name("share of messages off the line"),
            "",
            None,
            off,
            (0.0, FEW),
        ));
    }
    Ok(evidence.on(Claim {
        id: "fig-3-impulses",
        place: "Fig 3",
        claim: "Python's errors at 10 Hz are impulses: the series returns to its line.",
        check: "half of the messages lie within 10 ms of the resistant line, and at most a fifth are \
                off it (by more than five medians and 1 ms)",
    }))
}

/// What is left about the line of a group's first run.
fn residuals(source: &Source<'_>) -> Result<Option<Residuals>, ReadError> {
    let Some(run) = source.group.runs.first() else {
        return Ok(None);
    };
    Ok(Series::read(run)?.residuals())
}

fn python_is_not_flat(campaign: &Campaign) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    let mut still = Vec::new();
    for topology in NEAR {
        let source = Source::open(campaign, PYTHON, topology, paper::H_100_HZ_NS);
        evidence.ask(&source);
        let ours = slope(&source)?;
        let about = residuals(&source)?;
        let flat = judge(ours, &Limits::from((-FLAT, FLAT)));
        let accepted = (STEP as f64, f64::INFINITY);
        let of = source.name("messages in a row off the line");
        let longest = about.map(|about| Estimate::exact(about.longest as f64, about.n));
        let mut part = Part::judged(of, "", None, longest, accepted);
        // Without steps, what the slope is: not flat is what the paper has.
        part.verdict = match (part.verdict, flat) {
            (Verdict::Differs, Verdict::Differs) => Verdict::Agrees,
            (Verdict::Differs, Verdict::CannotBeTold) => Verdict::CannotBeTold,
            (verdict, _) => verdict,
        };
        if let (Some(ours), Verdict::Differs) = (ours, part.verdict) {
            still.push(format!("{} s/s on {topology}", number(ours.value)));
        }
        evidence.decide(part);
        evidence.show(Part::judged(source.name("slope"), "s/s", None, ours, ANY));
    }
    if !still.is_empty() {
        evidence.explain(format!(
            "Today's Python keeps 100 Hz on a machine and a link that do: its slope is {}.",
            still.join(", ")
        ));
    }
    Ok(evidence.on(Claim {
        id: "fig-4-python-not-flat",
        place: "Fig 4",
        claim: "At 100 Hz Python's series is no longer flat either: it has a slope, or steps.",
        check: "ten or more messages in a row are off the line (a step of a tenth of a second), or \
                the slope's 95 % interval lies beyond 0.001 s/s",
    }))
}
