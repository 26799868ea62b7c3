//! Readings of the paper: claims under settings that its text allows but does not state.
//!
//! Each names its strict claim, and is shown only if there are runs for it. The settings and the
//! reasons for them are in `experiments/readings.toml` and `profiles/diego-vpn-free.toml`.

use analysis::{Campaign, ReadError, Run, rows};
use endpoint::{ArrivalRow, TickRow};

use super::evidence::{Evidence, Source};
use super::interval::{NEAR, NO_PEAK, neighbours};
use super::plant::SPREAD;
use super::rare::Count;
use super::row::{self, Accepted, Claim, Judged, Metric, Row, Than};
use super::settling::{self, FOURFOLD, SETTLING};
use super::together::{self, WITHIN};
use super::words::fraction;
use crate::printed::{self, TABLE_3};
use crate::subject::Asked;
use crate::subject::{FIREFOX_2011, PYTHON};
use report::claim::Finding;
use report::claim::rule::ANY;
use report::group::Estimate;
use report::number::number;

/// The topology of the reading of Figure 9b.
const FREE: &str = "diego-vpn-free";
/// The step of a desktop's clock in the paper's years, 1/64 s: that of timestamps in Windows XP, and
/// so in its browsers.
const STAMP_NS: u64 = 1_000_000_000 / 64;
/// Share of Figure 7's standard deviation by which the plant's may differ.
const AS_NOISY: f64 = 0.2;

const AT_H: Metric = Metric::group(
    "share of intervals at h, by the stamps of ticks",
    "",
    |source| share(source, |spacing| spacing.at_h),
);
const ZERO: Metric = Metric::group(
    "share of intervals below h/10, by the stamps of ticks",
    "",
    |source| share(source, |spacing| spacing.zero),
);
const AT_H_ARRIVING: Metric = Metric::median(
    "share of intervals at h, by the stamps of arrivals",
    "",
    |m| m.arrivals.interval_at_h,
);
const TIMES: Metric = Metric {
    of: "settling over that on arima with the same plant",
    ..settling::TIMES
};

/// The readings for which there are runs.
pub(super) fn all(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let mut findings = Vec::new();
    let open = Source::of(campaign, FIREFOX_2011.open("arima", printed::H_100_HZ_NS));
    if !open.is_empty() {
        findings.push(table_3(&open)?);
    }
    let noisy = ["arima", FREE].map(|topology| Asked {
        is_noisy: true,
        ..PYTHON.closed(topology, printed::H_333_HZ_NS)
    });
    if campaign
        .runs
        .iter()
        .any(|run| noisy.iter().any(|asked| asked.is_for(run)))
    {
        for claim in figure_9b(noisy) {
            findings.push(row::judge(campaign, claim)?);
        }
    }
    Ok(findings)
}

/// Table 3's first number, with the timestamps of a clock of those years.
fn table_3(source: &Source<'_>) -> Result<Finding, ReadError> {
    let mut evidence = Evidence::default();
    evidence.ask(source);
    let mut count = Count { found: 0, of: 0 };
    for run in &source.group.runs {
        neighbours(run, |last, row| {
            count.of += 1;
            count.found += u64::from(last.t_arrive_ns / STAMP_NS == row.t_arrive_ns / STAMP_NS);
        })?;
    }
    let row = TABLE_3
        .iter()
        .find(|row| row.topology == "arima" && row.h_ns == printed::H_100_HZ_NS);
    if let Some(row) = row {
        let count = (count.of > 0).then_some(count);
        evidence.decide(together::counted(source, row, "1/64 s", count));
    }
    Ok(evidence.on(
        Claim {
            id: "reading-table-3-arima",
            reading_of: Some("table-3-100-hz"),
            place: "Table 3",
            claim: "Read by stamps that step by 1/64 s, as clocks of its years did, a quarter of JavaScript's \
                    messages at 100 Hz on arima come at the same time as the one before.",
            check: format!(
                "of the same rows as the claim's, with times cut to 1/64 s, the share of equal neighbours is \
                 the paper's within {}, or as far off as chance explains",
                fraction(WITHIN)
            ),
            ..Claim::default()
        },
    ))
}

/// Figures 9b and 6b, with packets that overtake each other and a plant as noisy as Figure 7's.
fn figure_9b([arima, vpn]: [Asked<'static>; 2]) -> [Claim; 2] {
    let more = Accepted::Above(Than {
        asked: arima,
        metric: ZERO,
        unknown: ANY,
    });
    let noise = printed::FIG_7.into_iter().filter(|of| of.h_ns == vpn.h_ns);
    let noise = noise.map(|of| {
        let like = (of.sd_ms * (1.0 - AS_NOISY), of.sd_ms * (1.0 + AS_NOISY));
        Row::new(arima, SPREAD, like).paper(of.sd_ms)
    });
    let decide = [
        Row::new(vpn, AT_H, (0.0, NO_PEAK)),
        Row::new(vpn, ZERO, more),
    ];
    let shown = [
        Row::shown(arima, AT_H),
        Row::shown(arima, ZERO),
        Row::shown(vpn, AT_H_ARRIVING),
        Row::shown(arima, AT_H_ARRIVING),
    ];
    [
        Claim {
            id: "reading-fig-9b-zeros",
            place: "Fig 9b",
            claim: "Read with packets that overtake each other and a plant as noisy as Figure 7's, more \
                    intervals are zero over the VPN, and there is no peak at 3 ms.",
            check: format!(
                "by the stamps of the ticks that took the commands up at most {} of the intervals are \
                 within h/{NEAR} of h, and more than on arima with the same plant are below h/{NEAR}; \
                 the plant's sample intervals have Figure 7's sd within {}",
                fraction(NO_PEAK),
                fraction(AS_NOISY)
            ),
            rows: decide.into_iter().chain(shown).chain(noise).collect(),
            reading_of: Some("fig-9b-zeros"),
            remark: Some(note_peaks),
        },
        Claim {
            id: "reading-fig-6b-settling-vpn",
            place: "Fig 6b",
            claim: "Read so, it takes four times as long over the VPN still.",
            check: settling::settles(FOURFOLD, "that on arima with the same plant"),
            rows: vec![
                Row::new(vpn, TIMES, FOURFOLD).paper(printed::FIG_6B_SETTLING),
                Row::shown(vpn, SETTLING),
                Row::shown(arima, SETTLING),
            ],
            reading_of: Some("fig-6b-settling-vpn"),
            remark: None,
        },
    ]
}

/// The third row is arima's share at h.
fn note_peaks(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    if let Some(at_h) = judged.get(2).and_then(|judged| judged.ours) {
        evidence.note(format!(
            "By the same stamps {} of the intervals on arima are at h, where Figure 8a has peaks: \
             this plant changes both figures alike, so they cannot both come out at once.",
            number(at_h.value)
        ));
    }
}

/// The median over the runs of the share that `part` is of all intervals.
fn share(source: &Source<'_>, part: fn(&Spacing) -> u64) -> Result<Option<Estimate>, ReadError> {
    let mut shares = Vec::new();
    for run in &source.group.runs {
        let spacing = Spacing::read(run)?;
        shares.extend(analysis::statistics::share(part(&spacing), spacing.all));
    }
    Ok(Estimate::median(&shares))
}

/// Counts of a run's intervals between commands by the timestamps of ticks: at h, zero, and all. The
/// time of a command is the timestamp of the first tick after its arrival.
#[derive(Default)]
struct Spacing {
    at_h: u64,
    zero: u64,
    all: u64,
}

impl Spacing {
    fn read(run: &Run) -> Result<Spacing, ReadError> {
        let mut ticks_ns = Vec::new();
        let path = run.folder.join("ticks.csv");
        rows::read(&path, TickRow::COLUMNS, |row: &TickRow| {
            ticks_ns.push(row.t_tick_ns);
        })?;
        let h_ns = i128::from(run.cell.settings.h.ns());
        let mut spacing = Spacing::default();
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
            spacing.all += 1;
            spacing.at_h += u64::from((interval_ns - h_ns).abs() * NEAR <= h_ns);
            spacing.zero += u64::from(interval_ns * NEAR < h_ns);
        })?;
        Ok(spacing)
    }
}
