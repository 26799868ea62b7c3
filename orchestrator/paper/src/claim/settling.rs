//! The step responses: Figures 5 and 6.

use analysis::{LoopVerdict, Run};

use super::evidence::{Evidence, Source};
use super::row::{Claim, Figure, Judged, Metric, NEAR, Row, Weight};
use super::words::{between, percent};
use crate::printed;
use crate::subject::Asked;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, PYTHON};
use report::group::Estimate;
use report::number::number;

/// Share of the reference by which the final value may be off: the band of settling.
const BAND: f64 = 0.02;
/// The share of runs that have to end stable; stalls may keep some from it. The interval of the share
/// has to be above this: six of six runs, seven of seven, nine of ten, or fifteen of twenty.
const MOST: f64 = 0.5;
/// "As without a network": settling relative to that on arima.
const AS_WITHOUT: (f64, f64) = (0.8, 1.3);
/// "Quadrupled".
pub(super) const FOURFOLD: (f64, f64) = (3.0, 5.0);
/// "Ten-fold".
const TENFOLD: (f64, f64) = (8.0, 12.0);

/// The rates of the step responses.
const RATES_NS: [u64; 2] = [printed::H_333_HZ_NS, printed::H_1_KHZ_NS];

const STABLE: Metric = Metric::group("share of runs that end stable", "", |source| {
    let (stable, n) = ended(source, LoopVerdict::Stable);
    Ok(Estimate::share(stable, n))
});
const GROWN: Metric = Metric::group("runs that grow", "", |source| {
    let (grown, n) = ended(source, LoopVerdict::Unstable);
    Ok((n > 0).then(|| Estimate::exact(grown as f64, n)))
});
const FINAL_VALUE: Metric = Metric {
    of: "final value",
    unit: "",
    figure: Figure::OrNever(|metrics| metrics.response?.final_value),
};
/// Infinite if half of the runs never settled.
pub(super) const SETTLING: Metric =
    Metric::group("settling", "ms", |source| Ok(source.group.settling_ms()));
pub(super) const TIMES: Metric = Metric {
    of: "settling over that of Python on arima",
    unit: "",
    figure: Figure::Settling,
};

/// Figure 5: Python on the three near positions, at both rates.
pub(super) fn figure_5() -> Vec<Claim> {
    let at = |h_ns| NEAR.map(|topology| PYTHON.closed(topology, h_ns));
    let all = RATES_NS.map(at).concat();
    let far = all.iter().filter(|asked| asked.topology != "arima");
    let last = (1.0 - BAND, 1.0 + BAND);
    vec![
        stable(
            "fig-5-stable",
            "Fig 5",
            "Python closes the loop on arima, buccoo and couva, at 333 Hz and at 1 kHz.",
            &all,
        ),
        Claim {
            id: "fig-5-final-value",
            place: "Fig 5",
            claim: "The responses end at the reference.",
            check: format!(
                "the mean of the last fifth is 1 within {}, in the median of the runs",
                percent(BAND)
            ),
            rows: all
                .iter()
                .map(|asked| Row::new(*asked, FINAL_VALUE, last).paper(1.0))
                .collect(),
            ..Claim::default()
        },
        Claim {
            id: "fig-5-settling",
            place: "Fig 5",
            claim: "Over buccoo's and couva's networks they settle as without one.",
            check: settles(AS_WITHOUT, "that on arima"),
            rows: far
                .flat_map(|asked| times(*asked, 1.0, AS_WITHOUT))
                .collect(),
            remark: Some(few),
            ..Claim::default()
        },
    ]
}

/// Figure 6: what a browser does to the loop, and what distance does.
pub(super) fn figure_6() -> Vec<Claim> {
    let javascript = FIREFOX_2011.closed("arima", printed::H_333_HZ_NS);
    let chromium = CHROMIUM_2011.closed("arima", printed::H_333_HZ_NS);
    let vpn = PYTHON.closed("diego-vpn", printed::H_333_HZ_NS);
    let lan = RATES_NS.map(|h_ns| PYTHON.closed("diego-lan", h_ns));
    let beside = Row::new(chromium, TIMES, TENFOLD).beside();
    let browser = times(javascript, printed::FIG_6A_SETTLING, TENFOLD);
    let as_lan = |asked| times(asked, printed::FIG_6C_SETTLING, AS_WITHOUT);
    vec![
        Claim {
            id: "fig-6a-settling-javascript",
            place: "Fig 6a",
            claim: "From JavaScript on arima at 333 Hz the loop takes ten times as long to settle.",
            check: settles(TENFOLD, "Python's on arima"),
            rows: browser.into_iter().chain([beside]).collect(),
            remark: Some(explain_pace),
            ..Claim::default()
        },
        Claim {
            id: "fig-6b-settling-vpn",
            place: "Fig 6b",
            claim: "From Python over the VPN at 333 Hz it takes four times as long.",
            check: settles(FOURFOLD, "Python's on arima"),
            rows: times(vpn, printed::FIG_6B_SETTLING, FOURFOLD).into(),
            remark: Some(few),
            ..Claim::default()
        },
        Claim {
            id: "fig-6c-settling-lan",
            place: "Fig 6c",
            claim: "From the data centre over the campus LAN it settles as without a network, at \
                    333 Hz and at 1 kHz.",
            check: settles(AS_WITHOUT, "Python's on arima"),
            rows: lan.into_iter().flat_map(as_lan).collect(),
            remark: Some(few),
            ..Claim::default()
        },
        stable(
            "fig-6-stable",
            "Fig 6",
            "From JavaScript, over the VPN and over the LAN alike the loop stays stable.",
            &[javascript, vpn, lan[0], lan[1]],
        ),
    ]
}

/// The claim that loops are stable: most runs are, and no run grows. A run with a stall in its last
/// part ends as not settled, which is no verdict on the loop; the reason names it.
fn stable(
    id: &'static str,
    place: &'static str,
    claim: &'static str,
    all: &[Asked<'static>],
) -> Claim {
    let rows = all.iter().flat_map(|asked| {
        [
            Row::new(*asked, STABLE, (MOST, 1.0)).paper(1.0),
            Row::new(*asked, GROWN, (0.0, 0.0)).paper(0.0),
        ]
    });
    Claim {
        id,
        place,
        claim,
        check: format!(
            "most runs end stable, at the reference within {} but for single excursions, and none \
             grows; one that meets a stall at its end may not have settled",
            percent(BAND)
        ),
        rows: rows.collect(),
        remark: Some(note_unsettled),
        ..Claim::default()
    }
}

/// The ratio decides; the two settling times are shown.
fn times(asked: Asked<'static>, paper: f64, accepted: (f64, f64)) -> [Row; 3] {
    [
        Row::shown(asked, SETTLING),
        Row::shown(PYTHON.closed("arima", asked.h_ns), SETTLING),
        Row::new(asked, TIMES, accepted).paper(paper),
    ]
}

/// What counts as agreement of a settling, in words.
pub(super) fn settles(accepted: (f64, f64), of: &str) -> String {
    format!(
        "settling into {}, median of the runs, is {} times {of}",
        percent(BAND),
        between(accepted)
    )
}

/// The number of runs with this verdict, and of all runs.
fn ended(source: &Source<'_>, so: LoopVerdict) -> (u64, u64) {
    let runs = &source.group.runs;
    let verdicts = runs
        .iter()
        .filter_map(|run| Some(run.metrics.as_ref()?.response?.verdict));
    let n = verdicts.filter(|verdict| *verdict == so).count();
    (n as u64, runs.len() as u64)
}

fn note_unsettled(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for Judged { source, .. } in judged {
        let (unsettled, n) = ended(source, LoopVerdict::NotSettled);
        if unsettled > 0 {
            evidence.note(format!(
                "{unsettled} of {n} runs of {} had not settled when they ended.",
                source.label()
            ));
        }
    }
}

/// Records small groups behind the numbers that decide, and behind those that they are computed from.
fn few(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    for judged in judged
        .iter()
        .filter(|judged| judged.row.weight != Weight::Beside)
    {
        evidence.few(&judged.source);
    }
}

/// Explains the pace: a client that advances its integrator by h per request is slower by the ratio
/// of its interval to h.
fn explain_pace(evidence: &mut Evidence, judged: &[Judged<'_>]) {
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
