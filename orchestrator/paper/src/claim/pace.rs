//! The pace of sending: JavaScript's at 100 Hz on arima, Figure 2 and the text on it, and pauses.
//!
//! The paper says what one run did, so each run is compared with it and no interval is needed.

use analysis::Run;
use analysis::statistics::{median, ms_between, share};
use endpoint::{ArrivalRow, MessageRow};

use super::evidence::Evidence;
use super::metric::Metric;
use super::row::Judged;
use super::source::Source;
use crate::printed;
use record::{ReadError, rows};
use report::number::number;

pub(super) const FIGURES: &[Metric] = &[
    Metric::each("from the first to the 600th message", "s", |run| {
        Ok(Start::read(run)?.ordinal_600_s)
    }),
    Metric::each("messages in the first 6 s", "", |run| {
        Ok(Some(Start::read(run)?.in_six_s as f64))
    }),
    Metric::each("sent of due", "", |run| Ok(sent(run))),
    Metric::each("longest pause in sending", "s", longest_pause_s),
    Metric::each("lag of sending", "s/s", |run| {
        let lag_s = Start::read(run)?.lag_s;
        Ok(lag_s.filter(|(_, s)| *s > 0.0).map(|(lag_s, s)| lag_s / s))
    }),
];

/// The numbers of a run's arrivals that Figure 2 and its text are about.
#[derive(Default)]
struct Start {
    /// From the first to the 600th arrival, s.
    ordinal_600_s: Option<f64>,
    /// Arrivals in the first six seconds.
    in_six_s: u64,
    /// How late the last message was sent if the first was on time, s, and how long after the first, s.
    lag_s: Option<(f64, f64)>,
    arrivals: u64,
}

impl Start {
    fn read(run: &Run) -> Result<Start, ReadError> {
        let h_s = run.cell.settings.h.ns() as f64 / 1e9;
        let mut first: Option<ArrivalRow> = None;
        let mut start = Start::default();
        let path = run.folder.join("arrivals.csv");
        rows::read(&path, |row: &ArrivalRow| {
            let first = *first.get_or_insert(*row);
            let since_s = ms_between(first.t_arrive_ns, row.t_arrive_ns) / 1e3;
            start.arrivals += 1;
            start.in_six_s += u64::from(since_s < 6.0);
            if start.arrivals == 600 {
                start.ordinal_600_s = Some(since_s);
            }
            if let (Some(from_ns), Some(send_ns)) = (first.t_send_ns, row.t_send_ns) {
                let sent_s = ms_between(from_ns, send_ns) / 1e3;
                let due_s = row.seq.saturating_sub(first.seq) as f64 * h_s;
                start.lag_s = Some((sent_s - due_s, sent_s));
            }
        })?;
        Ok(start)
    }
}

/// The longest time between two sendings. Messages of one connection each are sent in another order than they were due.
fn longest_pause_s(run: &Run) -> Result<Option<f64>, ReadError> {
    let mut sent_ns: Vec<u64> = Vec::new();
    rows::read(&run.folder.join("messages.csv"), |row: &MessageRow| {
        sent_ns.extend(row.t_send_ns);
    })?;
    sent_ns.sort_unstable();
    let pauses_ms = sent_ns.windows(2).map(|pair| ms_between(pair[0], pair[1]));
    Ok(pauses_ms.reduce(f64::max).map(|ms| ms / 1e3))
}

/// Messages sent, as a share of those due. The claim is about what one run did, so nothing is
/// inferred from other runs.
fn sent(run: &Run) -> Option<f64> {
    share(run.metrics.as_ref()?.messages.sent, run.cell.due())
}

/// Mean time per message, ms.
fn pace_ms(source: &Source<'_>) -> Option<f64> {
    let shares: Vec<f64> = source
        .group
        .runs
        .iter()
        .filter_map(|run| sent(run))
        .collect();
    let share = median(&shares).filter(|share| *share > 0.0)?;
    Some(source.h_s() * 1e3 / share)
}

/// The pace of the paper's ten minutes, ms per message.
fn whole_ms() -> f64 {
    printed::OPEN_LOOP_S * 1e3 / printed::SENT_IN_600_S
}

/// Explains the pace: the client's one thread waits for each answer, so any time beyond its timer
/// delays the next message.
pub(super) fn explain_whole(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    let Some(Judged { source, .. }) = judged.first() else {
        return;
    };
    let runs = source.group.runs.first();
    let metrics = runs.and_then(|run| run.metrics.as_ref());
    let rtt = metrics.map(|metrics| metrics.messages.rtt);
    let quantiles = rtt.and_then(|rtt| rtt.p50_ms.zip(rtt.p99_ms));
    let Some((ours_ms, (p50_ms, p99_ms))) = pace_ms(source).zip(quantiles) else {
        return;
    };
    evidence.explain(format!(
        "A message took {} ms in the paper and takes {} ms here: the page's one thread waits for \
         each answer, {} ms in the median and {} ms in one of a hundred, and what exceeds the \
         timer's 10 ms delays all later messages.",
        number(whole_ms()),
        number(ours_ms),
        number(p50_ms),
        number(p99_ms)
    ));
}

/// Explains a difference: the paper's numbers for this client have two paces, and ours has one of them.
pub(super) fn explain_start(evidence: &mut Evidence, judged: &[Judged<'_>]) {
    let ours_ms = judged.first().and_then(|judged| pace_ms(&judged.source));
    let Some(ours_ms) = ours_ms else {
        return;
    };
    let start_ms = printed::FIG_2_600TH_S * 1e3 / 599.0;
    let whole_ms = whole_ms();
    let nearer = if (ours_ms - whole_ms).abs() < (ours_ms - start_ms).abs() {
        "the ten minutes and not the start"
    } else {
        "the start and not the ten minutes"
    };
    evidence.explain(format!(
        "The paper's numbers have two paces, {} ms a message over the first 600 and {} ms over ten \
         minutes; ours takes {} ms, like {nearer}.",
        number(start_ms),
        number(whole_ms),
        number(ours_ms)
    ));
}
