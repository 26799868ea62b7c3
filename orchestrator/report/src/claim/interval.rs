//! The time between control commands: Figures 8 and 9.

use analysis::{Campaign, ReadError};

use super::evidence::{CHROMIUM, Claim, Evidence, FIREFOX, PYTHON, Source};
use super::histogram::{AT_H, Histogram, ZERO, ZERO_TICK};
use super::rule::ANY;
use super::words::number;
use super::{Finding, Limits, Part};
use crate::group::Estimate;
use crate::paper;

/// Most of them, for a histogram that is made of peaks.
const PEAKS: f64 = 0.5;
/// A histogram without a peak at h has at most this share there: what a flat one would have, were it
/// two h wide.
pub(super) const NO_PEAK: f64 = 0.1;
/// A client that is not sampled by h takes at least so many h.
const SLOW: f64 = 2.0;
/// The VPN's floor as the paper reads it, "on the order of 40 ms", with Table 2's least of 39.01.
const LEAST_RTT_MS: f64 = 39.0;

const EVERY_H: &str = "Here the client sends every h whatever is outstanding, and the link keeps the \
                       order of packets: the intervals at the plant are h but for what changes the \
                       delay between two packets.";

/// Figure 8: Python at 333 Hz on the three near positions.
pub(super) fn figure_8(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let read = |topology| {
        Histogram::read(Source::closed(
            campaign,
            PYTHON,
            topology,
            paper::H_333_HZ_NS,
        ))
    };
    let arima = read("arima")?;
    let (mut peaks, mut flatter, mut zeros): (Evidence, Evidence, Evidence) = Default::default();
    for evidence in [&mut peaks, &mut flatter, &mut zeros] {
        evidence.ask(&arima.source);
    }
    let of = "share of intervals at a multiple of h";
    peaks.decide(arima.part(of, arima.multiple, (PEAKS, 1.0)));
    peaks.decide(same_tick(&arima.source));
    peaks.show(arima.part(AT_H, arima.at_h, ANY));
    flatter.show(arima.part(AT_H, arima.at_h, ANY));
    zeros.show(arima.part(ZERO, arima.zero, ANY));
    zeros.show(arima.part(ZERO_TICK, arima.zero_tick, ANY));
    for topology in ["buccoo", "couva"] {
        let far = read(topology)?;
        flatter.ask(&far.source);
        flatter.decide(far.beside(AT_H, far.at_h, arima.at_h, Limits::below));
        zeros.ask(&far.source);
        zeros.decide(far.beside(ZERO, far.zero, arima.zero, Limits::above));
        zeros.decide(far.beside(ZERO_TICK, far.zero_tick, arima.zero_tick, Limits::above));
    }
    zeros.explain(EVERY_H);
    let ticks = arima.zero_tick.filter(Estimate::has_interval);
    if let (Some(zero), Some(tick)) = (arima.zero, ticks) {
        zeros.note(format!(
            "On arima {} of the intervals are below h/10, and {} to {} of the commands share a tick: \
             commands and ticks have one period, so that hangs on the phase that a run happens to \
             have.",
            number(zero.value),
            number(tick.low),
            number(tick.high)
        ));
    }
    Ok(vec![
        peaks.on(Claim {
            id: "fig-8-arima-peaks",
            place: "Fig 8a",
            claim: "On arima the control intervals at 333 Hz are multiples of the sample time, some \
                    of them zero.",
            check: "more than half are within h/10 of a multiple of h, where a flat histogram has a \
                    fifth, and some commands share a tick of the plant",
        }),
        flatter.on(Claim {
            id: "fig-8-flatter",
            place: "Fig 8b, 8c",
            claim: "On buccoo and couva the histograms are flatter.",
            check: "a lower share of intervals within h/10 of h than on arima",
        }),
        zeros.on(Claim {
            id: "fig-8-zeros",
            place: "Fig 8b, 8c",
            claim: "On buccoo and couva more intervals are zero.",
            check: "more intervals below h/10 than on arima, and more commands in one tick",
        }),
    ])
}

/// Whether there are any at all: counted over all runs of the group.
fn same_tick(source: &Source<'_>) -> Part {
    let metrics = source
        .group
        .runs
        .iter()
        .filter_map(|run| run.metrics.as_ref());
    let (mut same, mut all) = (0.0, 0);
    for arrivals in metrics.map(|metrics| &metrics.arrivals) {
        let intervals = arrivals.count.saturating_sub(1);
        same += arrivals.zero_tick.unwrap_or(0.0) * intervals as f64;
        all += intervals;
    }
    let found = (all > 0).then(|| Estimate::exact(same.round(), all));
    let of = source.name("commands in the same tick as the one before");
    Part::judged(of, "", None, found, (1.0, f64::INFINITY))
}

/// Figure 9: the slow browser, and the long way.
pub(super) fn figure_9(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let closed = |who, topology| Source::closed(campaign, who, topology, paper::H_333_HZ_NS);
    Ok(vec![
        browser(closed(FIREFOX, "arima"), closed(CHROMIUM, "arima"))?,
        delay(&closed(PYTHON, "diego-vpn")),
        far(closed(PYTHON, "diego-vpn"), closed(PYTHON, "arima"))?,
    ])
}

fn browser(firefox: Source<'_>, chromium: Source<'_>) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    evidence.ask(&firefox);
    evidence.ask_beside(&chromium);
    let parts = |source: Source<'_>| -> Result<[Part; 2], ReadError> {
        let histogram = Histogram::read(source)?;
        let source = &histogram.source;
        let mean = source.median(|run| run.metrics.as_ref()?.arrivals.interval_avg_ms);
        let least_ms = SLOW * source.h_s() * 1e3;
        let of = source.name("mean control interval");
        Ok([
            histogram.part(AT_H, histogram.at_h, (0.0, NO_PEAK)),
            Part::judged(of, "ms", None, mean, (least_ms, f64::INFINITY)),
        ])
    };
    let spread = firefox.median(|run| run.metrics.as_ref()?.arrivals.interval_sd_ms);
    let of = firefox.name("sd of the control intervals");
    let all = ANY;
    evidence.show(Part::judged(of, "ms", None, spread, all));
    parts(firefox)?
        .into_iter()
        .for_each(|part| evidence.decide(part));
    parts(chromium)?
        .into_iter()
        .for_each(|part| evidence.show(part));
    Ok(evidence.on(Claim {
        id: "fig-9a-no-peak",
        place: "Fig 9a",
        claim: "From JavaScript on arima at 333 Hz the control intervals are wide, with no peak at \
                3 ms.",
        check: "at most a tenth are within h/10 of h, and their mean is 2 h or more",
    }))
}

fn delay(vpn: &Source<'_>) -> Finding {
    let mut evidence = Evidence::default();
    evidence.ask(vpn);
    let least = vpn.median(|run| run.metrics.as_ref()?.messages.rtt_min_ms);
    evidence.decide(Part::judged(
        vpn.name("least round trip of a message"),
        "ms",
        Some(paper::FIG_9B_LEAST_RTT_MS),
        least,
        (LEAST_RTT_MS, f64::INFINITY),
    ));
    evidence.on(Claim {
        id: "fig-9b-delay",
        place: "Fig 9b",
        claim: "Over the VPN the delay of at least 40 ms shows.",
        check: "no answer comes in less than 39 ms, Table 2's least, in the median of the runs",
    })
}

fn far(vpn: Source<'_>, arima: Source<'_>) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    evidence.ask(&vpn);
    evidence.ask(&arima);
    let (vpn, arima) = (Histogram::read(vpn)?, Histogram::read(arima)?);
    evidence.decide(vpn.part(AT_H, vpn.at_h, (0.0, NO_PEAK)));
    evidence.decide(vpn.beside(ZERO, vpn.zero, arima.zero, Limits::above));
    evidence.show(vpn.part(ZERO_TICK, vpn.zero_tick, ANY));
    evidence.show(arima.part(ZERO_TICK, arima.zero_tick, ANY));
    evidence.explain(EVERY_H);
    let sd_ms = vpn
        .source
        .median(|run| run.metrics.as_ref()?.ticks.interval_sd_ms);
    let paper = paper::FIG_7.iter().find(|of| of.h_ns == vpn.source.h_ns);
    if let (Some(ours), Some(paper)) = (sd_ms, paper) {
        evidence.explain(format!(
            "The paper's server itself was off by {} ms (sd), as wide as h; ours by {} ms.",
            number(paper.sd_ms),
            number(ours.value)
        ));
    }
    Ok(evidence.on(Claim {
        id: "fig-9b-zeros",
        place: "Fig 9b",
        claim: "Over the VPN more intervals are zero, and there is no peak at 3 ms.",
        check: "at most a tenth of the intervals are within h/10 of h, and more than on arima are \
                below h/10",
    }))
}
