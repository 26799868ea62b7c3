//! Pings through the links: Table 2, and the text on couva.

use analysis::{Campaign, ReadError};
use link::{Band, Pings, Profile, predict};

use super::echo::{ECHOES_MIN, Series};
use super::evidence::{Claim, Evidence};
use super::rule::ANY;
use super::words::number;
use super::{Finding, Part, Verdict};
use crate::group::Estimate;
use crate::paper::{Ping, TABLE_2};

/// On loopback there is no law to be in the band of; this much, ms, is what a machine may take.
const LOOPBACK_AVG_MS: f64 = 1.0;
/// The paper's "up to seconds", ms.
const SECONDS_MS: f64 = 1000.0;
/// The paper's "tens of milliseconds": from a handful to a hundred.
const TENS_MS: (f64, f64) = (5.0, 100.0);

/// Table 2, a finding for each position.
pub(super) fn table_2(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    TABLE_2.iter().map(|row| position(campaign, row)).collect()
}

fn position(campaign: &Campaign, row: &Ping) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
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
    Ok(evidence.on(claim(row)))
}

fn claim(row: &Ping) -> Claim {
    let (id, claim) = match row.topology {
        "arima" => (
            "table-2-arima",
            "Ping on arima itself takes 0.1 ms and loses nothing.",
        ),
        "buccoo" => (
            "table-2-buccoo",
            "Ping from buccoo, wired, takes 3.4 ms and loses nothing.",
        ),
        "couva" => (
            "table-2-couva",
            "Ping from couva, on wireless, takes 104 ms with an sd of 336, and loses 1.6 %.",
        ),
        "diego-lan" => (
            "table-2-diego-lan",
            "Ping from the data centre over the campus takes 3.2 ms and loses 0.9 %.",
        ),
        _ => (
            "table-2-diego-vpn",
            "Ping from the data centre through the VPN takes 53 ms, at least 39, and loses nothing.",
        ),
    };
    let check = match row.topology {
        "arima" => "there is no link: less than 1 ms in the mean, and nothing lost",
        _ => {
            "min, avg, max, sd and loss of the echoes, less what the empty link takes, are where 99 % \
              of the profile's realisations have them, to what this machine plays exactly; Table 2's \
              are where those of a thousand pings are (its max, a single sample, within a factor of \
              two)"
        }
    };
    Claim {
        id,
        place: "Table 2",
        claim,
        check,
    }
}

fn loopback(evidence: &mut Evidence, series: &Series<'_>, row: &Ping) {
    let ours = series.statistics(0.0);
    let n = u64::from(series.sent);
    let came = series.rtt_ms.len() as u64;
    let mean = Estimate::mean(ours.avg_ms, ours.sd_ms, came);
    let own = |of: &str, unit, paper, ours, accepted: (f64, f64)| {
        Part::judged(format!("{of}, arima"), unit, Some(paper), ours, accepted)
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
    let columns: [(&str, &str, f64, f64, Band, Band, f64); 5] = [
        (
            "avg",
            "ms",
            row.avg_ms,
            ours.avg_ms,
            here.avg_ms,
            there.avg_ms,
            there.expected.avg_ms,
        ),
        (
            "min",
            "ms",
            row.min_ms,
            ours.min_ms,
            here.min_ms,
            there.min_ms,
            there.expected.min_ms,
        ),
        (
            "max",
            "ms",
            row.max_ms,
            ours.max_ms,
            here.max_ms,
            there.max_ms,
            there.expected.max_ms,
        ),
        (
            "sd",
            "ms",
            row.sd_ms,
            ours.sd_ms,
            here.sd_ms,
            there.sd_ms,
            there.expected.sd_ms,
        ),
        (
            "loss",
            "",
            row.loss,
            ours.loss,
            here.loss,
            there.loss,
            there.expected.loss,
        ),
    ];
    let n = u64::from(series.sent);
    let mut outside = Vec::new();
    for (of, unit, paper, ours, here, there, expected) in columns {
        let name = format!("{of} of {n} echoes, {}", row.topology);
        // The band has what chance makes of so many echoes: the number needs no interval of its own.
        let ours = Some(Estimate::exact(ours, n));
        let slack = if unit == "ms" { series.exact_ms } else { 0.0 };
        let part = Part::judged(
            name,
            unit,
            Some(paper),
            ours,
            (here.low - slack, here.high + slack),
        );
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
            "Beyond what 99 of 100 realisations of the profile give: the echoes' {}.",
            outside.join(", ")
        ));
    }
}

/// Whether Table 2 itself can be a realisation of the profile. What is judged is the paper's number,
/// so what stands for ours is the model's, with its band.
fn modelled(
    row: &Ping,
    of: &str,
    unit: &'static str,
    paper: f64,
    band: Band,
    expected: f64,
) -> Part {
    let slack = if of == "max" { 2.0 } else { 1.0 };
    let holds = (band.low / slack..=band.high * slack).contains(&paper);
    Part {
        of: format!("{of} of 1000 pings by the profile, {}", row.topology),
        unit,
        paper: Some(paper),
        ours: Some(Estimate {
            value: expected,
            low: band.low,
            high: band.high,
            n: u64::from(Pings::TABLE_2.count),
        }),
        accepted: None,
        verdict: match holds {
            true => Verdict::Agrees,
            false => Verdict::Differs,
        },
    }
}

/// The text on Table 2: up to seconds, and tens of milliseconds as a rule.
pub(super) fn couva(campaign: &Campaign) -> Result<Finding, ReadError> {
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
            let of = "longest echo, couva";
            evidence.decide(Part::judged(
                of,
                "ms",
                longest,
                most,
                (SECONDS_MS, f64::INFINITY),
            ));
            evidence.decide(Part::judged(
                "median echo, couva",
                "ms",
                None,
                median,
                TENS_MS,
            ));
            evidence.explain(format!(
                "The run has {n} echoes over {} s.",
                number(f64::from(series.sent) * series.interval_ns as f64 / 1e9)
            ));
        }
    }
    Ok(evidence.on(Claim {
        id: "text-couva-ping",
        place: "Section 3.1",
        claim: "An exchange can take up to seconds, and takes tens of milliseconds as a rule.",
        check: "on couva the longest echo takes a second or more, and the median 5 to 100 ms",
    }))
}
