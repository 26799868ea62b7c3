//! Pings through the links: Table 2, and the text on couva.

use analysis::Campaign;
use link::{Band, Pings, Profile, predict};

use super::echo::{ECHOES_MIN, Series};
use super::evidence::Evidence;
use crate::printed::{Ping, TABLE_2};
use crate::subject::Topology;
use record::ReadError;
use report::claim::rule::ANY;
use report::claim::{Part, Verdict};
use report::group::Estimate;
use report::number::number;

/// Greatest mean on loopback, ms: what a machine may take. There is no law, so there is no band.
pub(super) const LOOPBACK_AVG_MS: f64 = 1.0;
/// Table 2's maximum is a single sample: it may be off the band by this factor.
pub(super) const MAX_WITHIN: f64 = 2.0;
/// The paper's "up to seconds", ms.
const SECONDS_MS: f64 = 1000.0;
/// The paper's "tens of milliseconds": from a handful to a hundred.
pub(super) const TENS_MS: (f64, f64) = (5.0, 100.0);

/// A position of Table 2.
pub(super) fn position(campaign: &Campaign, topology: Topology) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    let Some(row) = TABLE_2.iter().find(|row| row.topology == topology.name()) else {
        evidence.lack(format!("a row of Table 2 for {}", topology.name()));
        return Ok(evidence);
    };
    let profile = campaign.plan.profiles.get(row.topology);
    let profile = profile.and_then(|text| text.profile(row.topology).ok());
    match (Series::longest(campaign, row.topology)?, profile) {
        (Some(series), Some(profile)) if profile.is_loopback() => {
            evidence.ask_cell(&series.run.cell.id);
            loopback(&mut evidence, &series, row);
        }
        (Some(series), Some(profile)) => {
            evidence.ask_cell(&series.run.cell.id);
            through(&mut evidence, &series, &profile, row);
        }
        _ => evidence.lack(format!("{ECHOES_MIN} echoes or more on {}", row.topology)),
    }
    Ok(evidence)
}

fn loopback(evidence: &mut Evidence, series: &Series<'_>, row: &Ping) {
    let ours = series.statistics(0.0);
    let n = u64::from(series.sent);
    let came = series.rtt_ms.len() as u64;
    let mean = Estimate::mean(ours.avg_ms, ours.sd_ms, came);
    let own = |of: &str, unit, paper, ours, accepted: (f64, f64)| {
        Part::judged(of, unit, Some(paper), ours, accepted).at("arima")
    };
    evidence.decide(own(
        "avg",
        "ms",
        row.avg_ms,
        Some(mean),
        (0.0, LOOPBACK_AVG_MS),
    ));
    let lost = analysis::statistics::share(n - came.min(n), n);
    let lost = lost.map(|lost| Estimate::exact(lost, n));
    evidence.decide(own("loss", "", row.loss, lost, (0.0, 0.0)));
    for (of, paper, ours) in [
        ("min", row.min_ms, ours.min_ms),
        ("max", row.max_ms, ours.max_ms),
        ("sd", row.sd_ms, ours.sd_ms),
    ] {
        evidence.show(own(of, "ms", paper, Some(Estimate::exact(ours, came)), ANY));
    }
}

fn through(evidence: &mut Evidence, series: &Series<'_>, profile: &Profile, row: &Ping) {
    let here = predict(
        profile,
        Pings {
            count: series.sent,
            interval_ns: series.interval_ns,
        },
    );
    let there = predict(profile, Pings::TABLE_2);
    let ours = series.statistics(series.own_ms);
    macro_rules! column {
        ($of:literal, $field:ident) => {{
            let (means, there) = (there.expected.$field, there.$field);
            ($of, row.$field, ours.$field, here.$field, there, means)
        }};
    }
    let columns = [
        column!("avg", avg_ms),
        column!("min", min_ms),
        column!("max", max_ms),
        column!("sd", sd_ms),
        column!("loss", loss),
    ];
    let n = u64::from(series.sent);
    let mut outside = Vec::new();
    for (of, paper, ours, here, there, expected) in columns {
        let unit = if of == "loss" { "" } else { "ms" };
        // The band includes the chance of this many echoes: the number needs no interval of its own.
        let ours = Some(Estimate::exact(ours, n));
        let slack = if unit == "ms" { series.exact_ms } else { 0.0 };
        let accepted = (here.low - slack, here.high + slack);
        let echoes = format!("{of} of {n} echoes");
        let part = Part::judged(echoes, unit, Some(paper), ours, accepted).at(row.topology);
        if part.verdict == Verdict::Differs {
            outside.push(of);
        }
        evidence.decide(part);
        evidence.decide(modelled(row, of, unit, paper, there, expected));
    }
    evidence.note(format!(
        "Echoes are within {} ms of what the link had for them, in the mean; the bands are wider by that.",
        number(series.exact_ms)
    ));
    if !outside.is_empty() {
        evidence.explain(format!(
            "Outside what 99 of 100 realisations of the profile give: the echoes' {}.",
            outside.join(", ")
        ));
    }
}

/// Whether Table 2 itself can be a realisation of the profile. Here the paper's number is judged, so
/// the model's value and band are in the place of ours.
fn modelled(
    row: &Ping,
    of: &str,
    unit: &'static str,
    paper: f64,
    band: Band,
    expected: f64,
) -> Part {
    let slack = if of == "max" { MAX_WITHIN } else { 1.0 };
    let holds = (band.low / slack..=band.high * slack).contains(&paper);
    let n = Pings::TABLE_2.count;
    let model = Estimate {
        value: expected,
        low: band.low,
        high: band.high,
        n: u64::from(n),
    };
    let pings = format!("{of} of {n} pings by the profile");
    Part {
        accepted: None,
        verdict: if holds {
            Verdict::Agrees
        } else {
            Verdict::Differs
        },
        ..Part::judged(pings, unit, Some(paper), Some(model), ANY).at(row.topology)
    }
}

/// The text on Table 2: up to seconds, and tens of milliseconds as a rule.
pub(super) fn couva(campaign: &Campaign) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    let row = TABLE_2.iter().find(|row| row.topology == "couva");
    let longest = row.map(|row| row.max_ms);
    match Series::longest(campaign, "couva")? {
        None => evidence.lack(format!("{ECHOES_MIN} echoes or more on couva")),
        Some(series) => {
            evidence.ask_cell(&series.run.cell.id);
            let n = u64::from(series.sent);
            let max_ms = series.statistics(series.own_ms).max_ms;
            let median = series.median_ms().map(|ms| Estimate::exact(ms, n));
            let most = Some(Estimate::exact(max_ms, n));
            let part = |of: &str, paper, ours, accepted: (f64, f64)| {
                Part::judged(of, "ms", paper, ours, accepted).at("couva")
            };
            evidence.decide(part(
                "longest echo",
                longest,
                most,
                (SECONDS_MS, f64::INFINITY),
            ));
            evidence.decide(part("median echo", None, median, TENS_MS));
            evidence.explain(format!(
                "The run has {n} echoes over {} s.",
                number(f64::from(series.sent) * series.interval_ns as f64 / 1e9)
            ));
        }
    }
    Ok(evidence)
}
