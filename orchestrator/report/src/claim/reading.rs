//! Readings of the paper: two claims under settings that its text allows and does not state.
//!
//! Each stands beside the strict claim, names it, and is shown only where there are runs for it. What the
//! settings are, and why, is in `experiments/readings.toml` and `profiles/diego-vpn-free.toml`.

use analysis::{Campaign, ReadError, Run, rows};
use endpoint::{ArrivalRow, TickRow};

use super::evidence::{Claim, Evidence, FIREFOX, Source};
use super::interval::NO_PEAK;
use super::rare::Count;
use super::rule::ANY;
use super::settling::{self, FOURFOLD};
use super::together;
use super::words::number;
use super::{Finding, Limits, Part};
use crate::group::Estimate;
use crate::paper::{self, TABLE_3};

/// The topology of the reading of Figure 9b.
const FREE: &str = "diego-vpn-free";
/// A desktop's clock in the paper's years stepped by 1/64 s: Windows XP's stamps do, and a browser's with
/// them.
const STAMP_NS: u64 = 1_000_000_000 / 64;
/// Part of Figure 7's spread that the plant's may differ by.
const AS_NOISY: f64 = 0.2;
/// An interval is at h, or zero, within a tenth of h.
const NEAR: i128 = 10;

/// The readings that there are runs for.
pub(super) fn all(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let mut findings = Vec::new();
    let open = Source::open(campaign, FIREFOX, "arima", paper::H_100_HZ_NS);
    if !open.is_empty() {
        findings.push(table_3(&open)?);
    }
    let [arima, vpn] = ["arima", FREE].map(|topology| Source::noisy(campaign, topology));
    if arima.group.planned + vpn.group.planned > 0 {
        findings.extend(figure_9b(&arima, &vpn)?);
    }
    Ok(findings)
}

/// Table 3's first number, by stamps of a clock of those years.
fn table_3(source: &Source<'_>) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    evidence.ask(source);
    let mut count = Count { found: 0, of: 0 };
    for run in &source.group.runs {
        let mut last = None;
        let path = run.folder.join("arrivals.csv");
        rows::read(&path, ArrivalRow::COLUMNS, |row: &ArrivalRow| {
            let stamp = row.t_arrive_ns / STAMP_NS;
            if let Some(last) = last.replace(stamp) {
                count.of += 1;
                count.found += u64::from(last == stamp);
            }
        })?;
    }
    let row = TABLE_3
        .iter()
        .find(|row| row.topology == "arima" && row.h_ns == paper::H_100_HZ_NS);
    if let Some(row) = row {
        let count = (count.of > 0).then_some(count);
        evidence.decide(together::counted(source, row, "1/64 s", count));
    }
    Ok(evidence.on_reading(
        Claim {
            id: "reading-table-3-arima",
            place: "Table 3",
            claim: "Read by stamps that step by 1/64 s, as clocks of its years did, a quarter of JavaScript's \
                    messages at 100 Hz on arima come at the same time as the one before.",
            check: "of the same rows as the claim's, with times cut to 1/64 s, the share of equal neighbours is \
                    the paper's within a fifth, or as far off as chance explains",
        },
        "table-3-100-hz",
    ))
}

/// Figure 9b and 6b, where packets overtake each other and the plant is as noisy as Figure 7's.
fn figure_9b(arima: &Source<'_>, vpn: &Source<'_>) -> Result<[Finding; 2], ReadError> {
    let (mut shape, mut settles): (Evidence, Evidence) = Default::default();
    for evidence in [&mut shape, &mut settles] {
        evidence.ask(vpn);
        evidence.ask(arima);
    }
    let (here, there) = (Spacing::of(arima)?, Spacing::of(vpn)?);
    let part = |source: &Source<'_>, of: &str, ours, limits: Limits| {
        Part::judged(source.name(of), "", None, ours, limits)
    };
    const AT_H: &str = "share of intervals at h, by the stamps of ticks";
    const ZERO: &str = "share of intervals below h/10, by the stamps of ticks";
    shape.decide(part(vpn, AT_H, there.at_h, (0.0, NO_PEAK).into()));
    let more = here.zero.map_or(Limits::from(ANY), Limits::above);
    shape.decide(part(vpn, ZERO, here.zero.and(there.zero), more));
    shape.show(part(arima, AT_H, here.at_h, ANY.into()));
    shape.show(part(arima, ZERO, here.zero, ANY.into()));
    let own =
        |source: &Source<'_>| source.median(|run| run.metrics.as_ref()?.arrivals.interval_at_h);
    for source in [vpn, arima] {
        let of = "share of intervals at h, by the stamps of arrivals";
        shape.show(part(source, of, own(source), ANY.into()));
    }
    if let Some(at_h) = here.at_h {
        shape.note(format!(
            "By the same stamps {} of the intervals on arima are at h, where Figure 8a has peaks: what this \
             plant does to Figure 9b it does to that too, so both are not had at once.",
            number(at_h.value)
        ));
    }
    for of in paper::FIG_7.iter().filter(|of| of.h_ns == vpn.h_ns) {
        let sd_ms = arima.median(|run| run.metrics.as_ref()?.ticks.interval_sd_ms);
        let like = (of.sd_ms * (1.0 - AS_NOISY), of.sd_ms * (1.0 + AS_NOISY));
        let name = arima.name("sd of the sample intervals");
        shape.decide(Part::judged(name, "ms", Some(of.sd_ms), sd_ms, like));
    }
    settles.decide(Part::judged(
        vpn.name("settling over that on arima with the same plant"),
        "",
        Some(paper::FIG_6B_SETTLING),
        settling::over(vpn, arima),
        FOURFOLD,
    ));
    for source in [vpn, arima] {
        let ms = settling::settling_ms(source);
        settles.show(Part::judged(source.name("settling"), "ms", None, ms, ANY));
    }
    Ok([
        shape.on_reading(
            Claim {
                id: "reading-fig-9b-zeros",
                place: "Fig 9b",
                claim: "Read with packets that overtake each other and a plant as noisy as Figure 7's, more \
                        intervals are zero over the VPN, and there is no peak at 3 ms.",
                check: "by the stamps of the ticks that took the commands up at most a tenth of the intervals are \
                        within h/10 of h, and more than on arima with the same plant are below h/10; the \
                        plant's sample intervals have Figure 7's sd within a fifth",
            },
            "fig-9b-zeros",
        ),
        settles.on_reading(
            Claim {
                id: "reading-fig-6b-settling-vpn",
                place: "Fig 6b",
                claim: "Read so, it takes four times as long over the VPN still.",
                check: "settling into 2 %, median of the runs, is 3 to 5 times that on arima with the same \
                        plant",
            },
            "fig-6b-settling-vpn",
        ),
    ])
}

/// How the intervals between commands are distributed by the stamps of ticks, each a median over runs.
struct Spacing {
    at_h: Option<Estimate>,
    zero: Option<Estimate>,
}

impl Spacing {
    fn of(source: &Source<'_>) -> Result<Spacing, ReadError> {
        let (mut at_h, mut zero) = (Vec::new(), Vec::new());
        for run in &source.group.runs {
            let (near, none, all) = count(run)?;
            at_h.extend(analysis::statistics::share(near, all));
            zero.extend(analysis::statistics::share(none, all));
        }
        Ok(Spacing {
            at_h: Estimate::median(&at_h),
            zero: Estimate::median(&zero),
        })
    }
}

/// Of a run's intervals how many are at h, how many zero, and all. A command's time is the stamp of the
/// first tick after it came.
fn count(run: &Run) -> Result<(u64, u64, u64), ReadError> {
    let mut ticks_ns = Vec::new();
    let path = run.folder.join("ticks.csv");
    rows::read(&path, TickRow::COLUMNS, |row: &TickRow| {
        ticks_ns.push(row.t_tick_ns);
    })?;
    let h_ns = i128::from(run.cell.settings.h.ns());
    let (mut near, mut none, mut all) = (0, 0, 0);
    let mut last_ns = None;
    let path = run.folder.join("arrivals.csv");
    rows::read(&path, ArrivalRow::COLUMNS, |row: &ArrivalRow| {
        let next = usize::try_from(row.tick)
            .ok()
            .and_then(|tick| tick.checked_add(1));
        let Some(stamp_ns) = next.and_then(|tick| ticks_ns.get(tick)) else {
            return;
        };
        let Some(last_ns) = last_ns.replace(*stamp_ns) else {
            return;
        };
        let interval_ns = i128::from(*stamp_ns) - i128::from(last_ns);
        all += 1;
        near += u64::from((interval_ns - h_ns).abs() * NEAR <= h_ns);
        none += u64::from(interval_ns * NEAR < h_ns);
    })?;
    Ok((near, none, all))
}
