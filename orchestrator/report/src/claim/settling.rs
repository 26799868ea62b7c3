//! The step responses: Figures 5 and 6.

use analysis::{Campaign, LoopVerdict, Run};

use super::evidence::{CHROMIUM, Claim, Evidence, FIREFOX, NEAR, PYTHON, RUNS_ASKED, Source, Who};
use super::rule::ANY;
use super::words::number;
use super::{Finding, Part};
use crate::group::Estimate;
use crate::paper;

/// Part of the reference that the final value may be off: the band of settling.
const BAND: f64 = 0.02;
/// The share of runs that have to end stable, where stalls may keep some from it. With the interval of
/// the share above it these are six of six, all of seven, nine of ten, or fifteen of twenty.
const MOST: f64 = 0.5;
const STABLE: &str = "most runs end stable, at the reference within 2 % but for single excursions, and none \
                      grows; one that meets a stall at its end may not have settled";
/// "As without a network": settling in settlings on arima.
const AS_WITHOUT: (f64, f64) = (0.8, 1.3);
/// "Quadrupled".
pub(super) const FOURFOLD: (f64, f64) = (3.0, 5.0);
/// "Ten-fold".
const TENFOLD: (f64, f64) = (8.0, 12.0);

/// Figure 5: Python on the three near positions, at both rates.
pub(super) fn figure_5(campaign: &Campaign) -> Vec<Finding> {
    let (mut stable, mut last, mut settles): (Evidence, Evidence, Evidence) = Default::default();
    for h_ns in [paper::H_333_HZ_NS, paper::H_1_KHZ_NS] {
        for topology in NEAR {
            let source = Source::closed(campaign, PYTHON, topology, h_ns);
            stays(&mut stable, &source);
            last.ask(&source);
            last.decide(final_value(&source));
            if topology != "arima" {
                compare(&mut settles, campaign, &source, 1.0, AS_WITHOUT);
            }
        }
    }
    vec![
        stable.on(Claim {
            id: "fig-5-stable",
            place: "Fig 5",
            claim: "Python closes the loop on arima, buccoo and couva, at 333 Hz and at 1 kHz.",
            check: STABLE,
        }),
        last.on(Claim {
            id: "fig-5-final-value",
            place: "Fig 5",
            claim: "The responses end at the reference.",
            check: "the mean of the last fifth is 1 within 2 %, in the median of the runs",
        }),
        settles.on(Claim {
            id: "fig-5-settling",
            place: "Fig 5",
            claim: "Over buccoo's and couva's networks they settle as without one.",
            check: "settling into 2 %, median of the runs, is 0.8 to 1.3 times that on arima",
        }),
    ]
}

/// Figure 6: what a browser does to the loop, and what distance does.
pub(super) fn figure_6(campaign: &Campaign) -> Vec<Finding> {
    let at = |who: Who, topology: &str, h_ns: u64| Source::closed(campaign, who, topology, h_ns);
    let javascript = at(FIREFOX, "arima", paper::H_333_HZ_NS);
    let vpn = at(PYTHON, "diego-vpn", paper::H_333_HZ_NS);
    let lan = [paper::H_333_HZ_NS, paper::H_1_KHZ_NS].map(|h_ns| at(PYTHON, "diego-lan", h_ns));

    let mut a = Evidence::default();
    compare(
        &mut a,
        campaign,
        &javascript,
        paper::FIG_6A_SETTLING,
        TENFOLD,
    );
    explain_pace(&mut a, &javascript);
    show(
        &mut a,
        campaign,
        &at(CHROMIUM, "arima", paper::H_333_HZ_NS),
        TENFOLD,
    );
    let mut b = Evidence::default();
    compare(&mut b, campaign, &vpn, paper::FIG_6B_SETTLING, FOURFOLD);
    let (mut c, mut stable) = (Evidence::default(), Evidence::default());
    for source in &lan {
        compare(&mut c, campaign, source, paper::FIG_6C_SETTLING, AS_WITHOUT);
    }
    for source in [&javascript, &vpn].into_iter().chain(&lan) {
        stays(&mut stable, source);
    }
    vec![
        a.on(Claim {
            id: "fig-6a-settling-javascript",
            place: "Fig 6a",
            claim: "From JavaScript on arima at 333 Hz the loop takes ten times as long to settle.",
            check: "settling into 2 %, median of the runs, is 8 to 12 times Python's on arima",
        }),
        b.on(Claim {
            id: "fig-6b-settling-vpn",
            place: "Fig 6b",
            claim: "From Python over the VPN at 333 Hz it takes four times as long.",
            check: "settling into 2 %, median of the runs, is 3 to 5 times Python's on arima",
        }),
        c.on(Claim {
            id: "fig-6c-settling-lan",
            place: "Fig 6c",
            claim: "From the data centre over the campus LAN it settles as without a network, at \
                    333 Hz and at 1 kHz.",
            check: "settling into 2 %, median of the runs, is 0.8 to 1.3 times Python's on arima",
        }),
        stable.on(Claim {
            id: "fig-6-stable",
            place: "Fig 6",
            claim: "From JavaScript, over the VPN and over the LAN alike the loop stays stable.",
            check: STABLE,
        }),
    ]
}

/// That the loop of a group is stable: most runs say so, and none says that it is not. A run whose last
/// part meets a stall ends as not settled, which is no verdict on the loop; the reason names it.
fn stays(evidence: &mut Evidence, source: &Source<'_>) {
    let runs = &source.group.runs;
    let n = runs.len() as u64;
    let count = |is: LoopVerdict| runs.iter().filter(|run| verdict(run) == Some(is)).count() as u64;
    evidence.ask(source);
    evidence.decide(Part::judged(
        source.name("share of runs that end stable"),
        "",
        Some(1.0),
        Estimate::share(count(LoopVerdict::Stable), n),
        (MOST, 1.0),
    ));
    let grown = count(LoopVerdict::Unstable);
    evidence.decide(Part::judged(
        source.name("runs that grow"),
        "",
        Some(0.0),
        (n > 0).then(|| Estimate::exact(grown as f64, n)),
        (0.0, 0.0),
    ));
    let unsettled = count(LoopVerdict::NotSettled);
    if unsettled > 0 {
        evidence.note(format!(
            "{unsettled} of {n} runs of {} had not settled when they ended.",
            source.label()
        ));
    }
}

fn verdict(run: &Run) -> Option<LoopVerdict> {
    Some(run.metrics.as_ref()?.response?.verdict)
}

fn final_value(source: &Source<'_>) -> Part {
    let values = source
        .group
        .values(|run| run.metrics.as_ref()?.response?.final_value);
    Part::judged(
        source.name("final value"),
        "",
        Some(1.0),
        Estimate::median_or_never(&values),
        (1.0 - BAND, 1.0 + BAND),
    )
}

/// Settling times of a group, in ms; infinite where a run never settled.
pub(super) fn settling_ms(source: &Source<'_>) -> Option<Estimate> {
    let values = source
        .group
        .values(|run| run.metrics.as_ref()?.response?.settling_ms);
    Estimate::median_or_never(&values)
}

/// Settling in settlings of Python on arima at the same rate.
pub(super) fn ratio(campaign: &Campaign, source: &Source<'_>) -> Option<Estimate> {
    over(
        source,
        &Source::closed(campaign, PYTHON, "arima", source.h_ns),
    )
}

/// Settling in settlings of another group.
pub(super) fn over(source: &Source<'_>, base: &Source<'_>) -> Option<Estimate> {
    let base_ms = settling_ms(base).filter(|base| base.value.is_finite() && base.value > 0.0)?;
    Some(settling_ms(source)?.over(base_ms))
}

/// The ratio decides; the settling times that it is made of are shown.
fn compare(
    evidence: &mut Evidence,
    campaign: &Campaign,
    source: &Source<'_>,
    paper: f64,
    accepted: (f64, f64),
) {
    let base = Source::closed(campaign, PYTHON, "arima", source.h_ns);
    for source in [source, &base] {
        evidence.ask(source);
        let n = source.group.runs.len();
        if (1..RUNS_ASKED).contains(&n) {
            evidence.few(source);
        }
        let of = source.name("settling");
        evidence.show(Part::judged(of, "ms", None, settling_ms(source), ANY));
    }
    let of = source.name("settling over that of Python on arima");
    let part = Part::judged(of, "", Some(paper), ratio(campaign, source), accepted);
    evidence.decide(part);
}

fn show(evidence: &mut Evidence, campaign: &Campaign, source: &Source<'_>, accepted: (f64, f64)) {
    evidence.ask_beside(source);
    let of = source.name("settling over that of Python on arima");
    evidence.show(Part::judged(
        of,
        "",
        None,
        ratio(campaign, source),
        accepted,
    ));
}

/// A client that advances its integrator by h a request is slower by its interval over h.
fn explain_pace(evidence: &mut Evidence, source: &Source<'_>) {
    let interval = source
        .group
        .values(|run| run.metrics.as_ref()?.arrivals.interval_avg_ms);
    if let Some(interval_ms) = Estimate::median(&interval) {
        evidence.explain(format!(
            "Its commands come every {} ms, and it integrates {} ms with each; ten times the settling \
             takes about 10.5 ms.",
            number(interval_ms.value),
            number(source.h_s() * 1e3)
        ));
    }
}
