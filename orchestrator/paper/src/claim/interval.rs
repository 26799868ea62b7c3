//! The time between control commands: Figures 8 and 9.

use analysis::{ReadError, Run, rows};
use endpoint::ArrivalRow;

use super::evidence::{Evidence, Source};
use super::rare::Count;
use super::row::{Accepted, Claim, Judged, Metric, Row, Than};
use super::words::fraction;
use crate::printed;
use crate::subject::Asked;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, PYTHON, Subject};
use report::group::Estimate;
use report::number::number;

/// More than this share of the intervals are in the peaks of a histogram that is made of peaks.
const PEAKS: f64 = 0.5;
/// A histogram without a peak at h has at most this share there: that of a flat one that is two h wide.
pub(super) const NO_PEAK: f64 = 0.1;
/// The mean interval of a client that does not keep h is at least this many h.
const SLOW: f64 = 2.0;
/// Least round trip over the VPN, ms: the paper says "on the order of 40 ms", and Table 2 has a
/// minimum of 39.01.
const LEAST_RTT_MS: f64 = 39.0;
/// An interval is at a multiple of h, or zero, if it is within h divided by this. Of evenly spread
/// intervals a fifth are.
pub(super) const NEAR: i128 = 10;

const EVERY_H: &str = "Here the client sends every h whatever is outstanding, and the link keeps the \
                       order of packets: the intervals at the plant are h but for what changes the \
                       delay between two packets.";

const AT_H: Metric = Metric::median("share of intervals at h", "", |m| m.arrivals.interval_at_h);
const MULTIPLE: Metric = Metric::group("share of intervals at a multiple of h", "", |source| {
    Spacing::share(source, |spacing| spacing.multiple)
});
const ZERO: Metric = Metric::group("share of intervals below h/10", "", |source| {
    Spacing::share(source, |spacing| spacing.zero)
});
const ZERO_TICK: Metric = Metric::median(
    "share of commands in the same tick as the one before",
    "",
    |m| m.arrivals.zero_tick,
);
/// Counted over all runs of the group, since the question is whether there are any at all.
const SAME_TICK: Metric = Metric::group(
    "commands in the same tick as the one before",
    "",
    |source| {
        let count = Count::over(source, |m| (m.arrivals.zero_tick, m.arrivals.count));
        Ok(count.map(|count| Estimate::exact(count.found as f64, count.of)))
    },
);
const MEAN: Metric = Metric::median("mean control interval", "ms", |m| {
    m.arrivals.interval_avg_ms
});
const SPREAD: Metric = Metric::median("sd of the control intervals", "ms", |m| {
    m.arrivals.interval_sd_ms
});
const LEAST_RTT: Metric = Metric::median("least round trip of a message", "ms", |m| {
    m.messages.rtt_min_ms
});

const fn closed(subject: Subject, topology: &'static str) -> Asked<'static> {
    subject.closed(topology, printed::H_333_HZ_NS)
}

/// The value of arima, as a limit for another topology.
const fn than_arima(metric: Metric) -> Than {
    Than {
        asked: closed(PYTHON, "arima"),
        metric,
        unknown: (0.0, 1.0),
    }
}

/// Figure 8: Python at 333 Hz on the three near positions.
pub(super) fn figure_8() -> Vec<Claim> {
    let arima = closed(PYTHON, "arima");
    let far = ["buccoo", "couva"].map(|topology| closed(PYTHON, topology));
    let flatter = far.map(|far| Row::new(far, AT_H, Accepted::Below(than_arima(AT_H))));
    let more = |far, metric| Row::new(far, metric, Accepted::Above(than_arima(metric)));
    let zeros = far.map(|far| [more(far, ZERO), more(far, ZERO_TICK)]);
    vec![
        Claim {
            id: "fig-8-arima-peaks",
            place: "Fig 8a",
            claim: "On arima the control intervals at 333 Hz are multiples of the sample time, some \
                    of them zero.",
            check: format!(
                "more than {} are within h/{NEAR} of a multiple of h, where a flat histogram has {}, \
                 and some commands share a tick of the plant",
                fraction(PEAKS),
                fraction(2.0 / NEAR as f64)
            ),
            rows: vec![
                Row::new(arima, MULTIPLE, (PEAKS, 1.0)),
                Row::new(arima, SAME_TICK, (1.0, f64::INFINITY)),
                Row::shown(arima, AT_H),
            ],
            ..Claim::default()
        },
        Claim {
            id: "fig-8-flatter",
            place: "Fig 8b, 8c",
            claim: "On buccoo and couva the histograms are flatter.",
            check: format!("a lower share of intervals within h/{NEAR} of h than on arima"),
            rows: [Row::shown(arima, AT_H)]
                .into_iter()
                .chain(flatter)
                .collect(),
            ..Claim::default()
        },
        Claim {
            id: "fig-8-zeros",
            place: "Fig 8b, 8c",
            claim: "On buccoo and couva more intervals are zero.",
            check: format!(
                "more intervals below h/{NEAR} than on arima, and more commands in one tick"
            ),
            rows: [[ZERO, ZERO_TICK].map(|metric| Row::shown(arima, metric))]
                .into_iter()
                .chain(zeros)
                .flatten()
                .collect(),
            remark: Some(note_phase),
            ..Claim::default()
        },
    ]
}

/// Figure 9: the slow browser, and the VPN.
pub(super) fn figure_9() -> Vec<Claim> {
    let [firefox, chromium] = [FIREFOX_2011, CHROMIUM_2011].map(|subject| closed(subject, "arima"));
    let (vpn, arima) = (closed(PYTHON, "diego-vpn"), closed(PYTHON, "arima"));
    let no_peak = |asked| Row::new(asked, AT_H, (0.0, NO_PEAK));
    let least_ms = SLOW * (printed::H_333_HZ_NS as f64 / 1e9) * 1e3;
    let slow = |asked| Row::new(asked, MEAN, (least_ms, f64::INFINITY));
    let least = Row::new(vpn, LEAST_RTT, (LEAST_RTT_MS, f64::INFINITY));
    vec![
        Claim {
            id: "fig-9a-no-peak",
            place: "Fig 9a",
            claim: "From JavaScript on arima at 333 Hz the control intervals are wide, with no peak at \
                    3 ms.",
            check: format!(
                "at most {} are within h/{NEAR} of h, and their mean is {SLOW} h or more",
                fraction(NO_PEAK)
            ),
            rows: vec![
                Row::shown(firefox, SPREAD),
                no_peak(firefox),
                slow(firefox),
                no_peak(chromium).beside(),
                slow(chromium).beside(),
            ],
            ..Claim::default()
        },
        Claim {
            id: "fig-9b-delay",
            place: "Fig 9b",
            claim: "Over the VPN the delay of at least 40 ms shows.",
            check: format!(
                "no answer comes in less than {LEAST_RTT_MS} ms, Table 2's least, in the median of the \
                 runs"
            ),
            rows: vec![least.paper(printed::FIG_9B_LEAST_RTT_MS)],
            ..Claim::default()
        },
        Claim {
            id: "fig-9b-zeros",
            place: "Fig 9b",
            claim: "Over the VPN more intervals are zero, and there is no peak at 3 ms.",
            check: format!(
                "at most {} of the intervals are within h/{NEAR} of h, and more than on arima are below \
                 h/{NEAR}",
                fraction(NO_PEAK)
            ),
            rows: vec![
                no_peak(vpn),
                Row::new(vpn, ZERO, Accepted::Above(than_arima(ZERO))),
                Row::shown(vpn, ZERO_TICK),
                Row::shown(arima, ZERO_TICK),
            ],
            remark: Some(explain_order),
            ..Claim::default()
        },
    ]
}

/// Passes each arrival of a run except the first to `each`, after the one before it.
pub(super) fn neighbours(
    run: &Run,
    mut each: impl FnMut(&ArrivalRow, &ArrivalRow),
) -> Result<(), ReadError> {
    let (mut last, path) = (None, run.folder.join("arrivals.csv"));
    rows::read(&path, ArrivalRow::COLUMNS, |row: &ArrivalRow| {
        if let Some(last) = last.replace(*row) {
            each(&last, row);
        }
    })?;
    Ok(())
}

/// Counts of the intervals of a run.
#[derive(Debug, Default)]
struct Spacing {
    count: u64,
    /// Those within h/10 of a multiple of h, from h on.
    multiple: u64,
    /// Those below h/10.
    zero: u64,
}

impl Spacing {
    fn read(run: &Run) -> Result<Spacing, ReadError> {
        let h_ns = i128::from(run.cell.settings.h.ns());
        let mut spacing = Spacing::default();
        neighbours(run, |last, row| {
            let interval_ns = i128::from(row.t_arrive_ns) - i128::from(last.t_arrive_ns);
            let off_ns = (interval_ns + h_ns / 2).rem_euclid(h_ns) - h_ns / 2;
            spacing.count += 1;
            if interval_ns * NEAR < h_ns {
                spacing.zero += 1;
            } else if off_ns.abs() * NEAR <= h_ns {
                spacing.multiple += 1;
            }
        })?;
        Ok(spacing)
    }

    /// The median over the runs of the share that `part` is of all intervals.
    fn share(
        source: &Source<'_>,
        part: fn(&Spacing) -> u64,
    ) -> Result<Option<Estimate>, ReadError> {
        let mut shares = Vec::new();
        for run in &source.group.runs {
            let spacing = Spacing::read(run)?;
            shares.extend(analysis::statistics::share(part(&spacing), spacing.count));
        }
        Ok(Estimate::median(&shares))
    }
}

/// The first two rows are arima's.
fn note_phase(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    evidence.explain(EVERY_H);
    let [zero, tick, ..] = judged else { return };
    let tick = tick.ours.filter(Estimate::has_interval);
    if let (Some(zero), Some(tick)) = (zero.ours, tick) {
        evidence.note(format!(
            "On arima {} of the intervals are below h/10, and {} to {} of the commands share a \
             tick: commands and ticks have one period, so this depends on the phase that a run \
             happens to have.",
            number(zero.value),
            number(tick.low),
            number(tick.high)
        ));
    }
}

fn explain_order(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    evidence.explain(EVERY_H);
    let Some(Judged { source: vpn, .. }) = judged.first() else {
        return;
    };
    let sd_ms = vpn
        .group
        .median(|run| run.metrics.as_ref()?.ticks.interval_sd_ms);
    let paper = printed::FIG_7.iter().find(|of| of.h_ns == vpn.asked.h_ns);
    if let (Some(ours), Some(paper)) = (sd_ms, paper) {
        evidence.explain(format!(
            "The paper's server itself was off by {} ms (sd), as wide as h; ours by {} ms.",
            number(paper.sd_ms),
            number(ours.value)
        ));
    }
}
