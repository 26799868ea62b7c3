//! The pace of JavaScript at 100 Hz on arima: Figure 2 and the text on it.
//!
//! The paper says what one run did, so each run is held against it and no interval is needed.

use analysis::{Campaign, ReadError, Run, rows};
use endpoint::ArrivalRow;

use super::evidence::{CHROMIUM, Claim, Evidence, FIREFOX, Source};
use super::words::number;
use super::{Finding, Part};
use crate::group::Estimate;
use crate::paper;

/// "Two seconds late", read to half a second.
const READ_TO_S: f64 = 0.5;
/// "Just shy of 400" is no less than this.
const JUST_SHY: f64 = 380.0;
/// Part of the paper's number by which a count may differ.
const COUNT_WITHIN: f64 = 0.05;
/// Part of the paper's number by which what is "roughly" so may differ.
const ROUGHLY: f64 = 0.2;

/// Figure 2 and the text on it: 100 Hz from JavaScript on arima.
pub(super) fn figure_2(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let sources =
        [FIREFOX, CHROMIUM].map(|who| Source::open(campaign, who, "arima", paper::H_100_HZ_NS));
    let mut findings: [Evidence; 4] = Default::default();
    for (place, source) in sources.iter().enumerate() {
        let starts = source.group.runs.iter().map(|run| Start::read(run));
        let starts = starts.collect::<Result<Vec<_>, _>>()?;
        let parts = [
            ordinal_600(source, &starts),
            in_six_s(source, &starts),
            sent(source),
            lag(source, &starts),
        ];
        // The first two are about the start, the others about all ten minutes.
        let explanations = [explain_start, explain_start, explain_whole, explain_whole];
        for ((evidence, part), explain) in findings.iter_mut().zip(parts).zip(explanations) {
            match place {
                0 => {
                    evidence.ask(source);
                    explain(evidence, source);
                    evidence.decide(part);
                }
                _ => {
                    evidence.ask_beside(source);
                    evidence.show(part);
                }
            }
        }
    }
    let claims = [
        Claim {
            id: "fig-2-600th",
            place: "Fig 2",
            claim: "The JavaScript client at 100 Hz on arima sends its 600th message two seconds late.",
            check: "the 600th message arrives 7.5 to 8.5 s after the first; on time is 5.99 s",
        },
        Claim {
            id: "fig-2-in-6-s",
            place: "Fig 2",
            claim: "In the first six seconds it sends just under 400 messages.",
            check: "380 to 400 messages arrive in the first 6 s; on time are 600",
        },
        Claim {
            id: "text-sent",
            place: "Section 4.1",
            claim: "In ten minutes it sends 55 thousand of 60 thousand messages.",
            check: "the share of due messages that were sent is 0.917 within 5 %, however long the run",
        },
        Claim {
            id: "text-lag",
            place: "Section 4.1",
            claim: "After ten minutes its open-loop control is roughly 50 s behind.",
            check: "the last message is sent 1/12 s late for each second that has passed, within 20 %",
        },
    ];
    let found = findings.into_iter().zip(claims);
    Ok(found.map(|(evidence, claim)| evidence.on(claim)).collect())
}

/// What of a run's arrivals Figure 2 and its text are about.
struct Start {
    /// From the first to the 600th arrival, s.
    ordinal_600_s: Option<f64>,
    /// Arrivals in the first six seconds.
    in_six_s: u64,
    /// How late the last message was sent, the first being on time, s, and how long after it, s.
    lag_s: Option<(f64, f64)>,
    arrivals: u64,
}

impl Start {
    fn read(run: &Run) -> Result<Start, ReadError> {
        let h_s = run.cell.settings.h.ns() as f64 / 1e9;
        let mut first: Option<ArrivalRow> = None;
        let mut start = Start {
            ordinal_600_s: None,
            in_six_s: 0,
            lag_s: None,
            arrivals: 0,
        };
        let path = run.folder.join("arrivals.csv");
        rows::read(&path, ArrivalRow::COLUMNS, |row: &ArrivalRow| {
            let first = *first.get_or_insert(*row);
            let since_s = since_s(first.t_arrive_ns, row.t_arrive_ns);
            start.arrivals += 1;
            start.in_six_s += u64::from(since_s < 6.0);
            if start.arrivals == 600 {
                start.ordinal_600_s = Some(since_s);
            }
            let sent_s = self::since_s(first.t_send_ns, row.t_send_ns);
            let due_s = row.seq.saturating_sub(first.seq) as f64 * h_s;
            start.lag_s = Some((sent_s - due_s, sent_s));
        })?;
        Ok(start)
    }
}

fn since_s(from_ns: u64, to_ns: u64) -> f64 {
    analysis::statistics::ms_between(from_ns, to_ns) / 1e3
}

fn ordinal_600(source: &Source<'_>, starts: &[Start]) -> Part {
    let values: Vec<f64> = starts
        .iter()
        .filter_map(|start| start.ordinal_600_s)
        .collect();
    let around = paper::FIG_2_600TH_S;
    Part::judged(
        source.name("from the first to the 600th message"),
        "s",
        Some(around),
        Estimate::of_each(&values),
        (around - READ_TO_S, around + READ_TO_S),
    )
}

fn in_six_s(source: &Source<'_>, starts: &[Start]) -> Part {
    let values: Vec<f64> = starts.iter().map(|start| start.in_six_s as f64).collect();
    Part::judged(
        source.name("messages in the first 6 s"),
        "",
        Some(paper::FIG_2_IN_6_S),
        Estimate::of_each(&values),
        (JUST_SHY, paper::FIG_2_IN_6_S),
    )
}

fn sent(source: &Source<'_>) -> Part {
    let share = paper::SENT_IN_600_S / paper::DUE_IN_600_S;
    Part::judged(
        source.name("sent of due"),
        "",
        Some(share),
        sent_share(source),
        (share * (1.0 - COUNT_WITHIN), share * (1.0 + COUNT_WITHIN)),
    )
}

/// Of each run. The claim is of what one run did, so none of another is inferred.
fn sent_share(source: &Source<'_>) -> Option<Estimate> {
    let of = |run: &&Run| {
        let metrics = run.metrics.as_ref()?;
        analysis::statistics::share(metrics.messages.sent, run.cell.due())
    };
    let shares: Vec<f64> = source.group.runs.iter().filter_map(of).collect();
    Estimate::of_each(&shares)
}

fn lag(source: &Source<'_>, starts: &[Start]) -> Part {
    let rate = |start: &Start| {
        start
            .lag_s
            .filter(|(_, s)| *s > 0.0)
            .map(|(lag_s, s)| lag_s / s)
    };
    let values: Vec<f64> = starts.iter().filter_map(rate).collect();
    let around = paper::LAG_AFTER_600_S / paper::OPEN_LOOP_S;
    Part::judged(
        source.name("lag of sending"),
        "s/s",
        Some(around),
        Estimate::of_each(&values),
        (around * (1.0 - ROUGHLY), around * (1.0 + ROUGHLY)),
    )
}

/// What a message takes in the mean, ms.
fn pace_ms(source: &Source<'_>) -> Option<f64> {
    let share = sent_share(source).filter(|share| share.value > 0.0)?;
    Some(source.h_s() * 1e3 / share.value)
}

/// The pace of the paper's ten minutes, ms a message.
fn whole_ms() -> f64 {
    paper::OPEN_LOOP_S * 1e3 / paper::SENT_IN_600_S
}

/// The client's one thread waits for each answer, so whatever is beyond its timer delays the next.
fn explain_whole(evidence: &mut Evidence, source: &Source<'_>) {
    let runs = source.group.runs.first();
    let metrics = runs.and_then(|run| run.metrics.as_ref());
    let rtt = metrics.map(|metrics| metrics.messages.rtt);
    let quantiles = rtt.and_then(|rtt| rtt.p50_ms.zip(rtt.p99_ms));
    let Some((ours_ms, (p50_ms, p99_ms))) = pace_ms(source).zip(quantiles) else {
        return;
    };
    evidence.explain(format!(
        "A message took {} ms in the paper and takes {} ms here: the page's one thread waits for each \
         answer, {} ms in the median and {} ms in one of a hundred, and what of it goes beyond the \
         timer's 10 ms delays all that follow.",
        number(whole_ms()),
        number(ours_ms),
        number(p50_ms),
        number(p99_ms)
    ));
}

/// The paper's numbers on this client are of two paces; which one ours has explains what differs.
fn explain_start(evidence: &mut Evidence, source: &Source<'_>) {
    let Some(ours_ms) = pace_ms(source) else {
        return;
    };
    let start_ms = paper::FIG_2_600TH_S * 1e3 / 599.0;
    let whole_ms = whole_ms();
    let nearer = match (ours_ms - whole_ms).abs() < (ours_ms - start_ms).abs() {
        true => "the ten minutes and not the start",
        false => "the start and not the ten minutes",
    };
    evidence.explain(format!(
        "The paper's numbers are of two paces, {} ms a message over the first 600 and {} ms over ten \
         minutes; ours takes {} ms, like {nearer}.",
        number(start_ms),
        number(whole_ms),
        number(ours_ms)
    ));
}
