//! Messages that came at the same time as the one before: Table 3.
//!
//! What counts as the same time depends on the clock. Timestamps of 10 ms reproduce the paper's row
//! at 100 Hz, so they decide; finer ones are only shown.

use analysis::Campaign;
use endpoint::SampleTime;

use super::evidence::Evidence;
use super::interval::neighbours;
use super::rare::{Count, alike};
use super::source::Source;
use crate::printed::{self, SameTime, TABLE_3};
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, Subject};
use record::ReadError;
use report::claim::rule::COUNT_MIN;
use report::claim::{Part, Verdict};
use report::number::number;

/// Share of the paper's value by which a value may differ, if that is more than chance explains.
pub(super) const WITHIN: f64 = 0.2;
/// The assumed step of the paper's timestamps, ns.
const STAMP_NS: u64 = 10_000_000;
/// The step of a desktop's clock in the paper's years, 1/64 s: that of timestamps in Windows XP, and
/// so in its browsers.
const COARSE_NS: u64 = 1_000_000_000 / 64;

/// Table 3 at one rate.
pub(super) fn table_3(campaign: &Campaign, h: SampleTime) -> Result<Evidence, ReadError> {
    let mut evidence = Evidence::default();
    let mut close = Vec::new();
    for row in TABLE_3.iter().filter(|row| row.h_ns == h.ns()) {
        close.extend(cell(&mut evidence, campaign, row)?);
    }
    if !close.is_empty() {
        evidence.explain(format!(
            "Two share a stamp of 10 ms only where they come within 10 ms of each other; the share \
             that does is {}.",
            close.join(", ")
        ));
    }
    Ok(evidence)
}

/// A reading of Table 3's first number, with the timestamps of a clock of those years; `None` without runs.
pub(super) fn coarse(campaign: &Campaign) -> Result<Option<Evidence>, ReadError> {
    let [row, ..] = &TABLE_3;
    let source = Source::of(campaign, FIREFOX_2011.open(row.topology, row.h_ns));
    if source.is_empty() {
        return Ok(None);
    }
    let mut evidence = Evidence::default();
    evidence.ask(&source);
    let mut count = Count { found: 0, of: 0 };
    for run in &source.group.runs {
        neighbours(run, |last, row| {
            count.of += 1;
            count.found += u64::from(last.t_arrive_ns / COARSE_NS == row.t_arrive_ns / COARSE_NS);
        })?;
    }
    let count = (count.of > 0).then_some(count);
    evidence.decide(counted(&source, row, "1/64 s", count));
    Ok(Some(evidence))
}

fn cell(
    evidence: &mut Evidence,
    campaign: &Campaign,
    row: &SameTime,
) -> Result<Option<String>, ReadError> {
    let source = |subject: Subject| Source::of(campaign, subject.open(row.topology, row.h_ns));
    let (firefox, chromium) = (source(FIREFOX_2011), source(CHROMIUM_2011));
    evidence.ask(&firefox);
    evidence.ask_beside(&chromium);
    let decides = counted(&firefox, row, "10 ms", in_10_ms(&firefox));
    let close = match decides.verdict {
        Verdict::Differs => close(&firefox, row.topology)?,
        _ => None,
    };
    if let Some(ours) = decides.ours.filter(|_| row.share > 0.0) {
        let expected = row.share * ours.n as f64;
        let found = ours.value * ours.n as f64;
        evidence.note(format!(
            "On {} the paper's share of the {} here would be {}; found: {}.",
            row.topology,
            ours.n,
            number(expected),
            found.round()
        ));
    }
    evidence.decide(decides);
    let finer = Count::over(&firefox, |m| (m.arrivals.zero_1ms, m.arrivals.count));
    evidence.show(counted(&firefox, row, "1 ms", finer));
    let exact = Count::over(&firefox, |m| (m.arrivals.zero_exact, m.arrivals.count));
    evidence.show(counted(&firefox, row, "1 ns", exact));
    evidence.show(counted(&chromium, row, "10 ms", in_10_ms(&chromium)));
    Ok(close)
}

/// A count compared with the paper's share.
fn counted(source: &Source<'_>, row: &SameTime, clock: &str, count: Option<Count>) -> Part {
    let chance = count.map_or((row.share, row.share), |ours| {
        alike(paper_count(row), ours.of)
    });
    let accepted = (
        chance.0.min(row.share * (1.0 - WITHIN)),
        chance.1.max(row.share * (1.0 + WITHIN)),
    );
    let part = source.part(
        &format!("share of neighbours in the same {clock}"),
        "",
        Some(row.share),
        // The limits include the chance of both counts: the number needs no interval of its own.
        count.and_then(Count::share),
        accepted,
    );
    let expected = count.map(|ours| row.share * ours.of as f64);
    let is_rare = expected.is_some_and(|n| n > 0.0 && n < COUNT_MIN);
    match part.verdict {
        Verdict::Agrees if is_rare => Part {
            verdict: Verdict::CannotBeTold,
            ..part
        },
        _ => part,
    }
}

/// Consecutive arrivals with the same timestamp of 10 ms, which is the one that decides.
pub(super) fn in_10_ms(source: &Source<'_>) -> Option<Count> {
    Count::over(source, |m| (m.arrivals.zero_10ms, m.arrivals.count))
}

/// The paper's count. Its messages are those due in ten minutes, less the twelfth that is missing at
/// 100 Hz according to its text; the slower rates lose next to nothing.
fn paper_count(row: &SameTime) -> Count {
    let due = printed::OPEN_LOOP_S * 1e9 / row.h_ns as f64;
    let sent = match row.h_ns {
        printed::H_100_HZ_NS => printed::SENT_IN_600_S,
        _ => due,
    };
    Count {
        found: (row.share * sent).round() as u64,
        of: sent as u64,
    }
}

/// The share of consecutive arrivals that are less than a timestamp's step apart, and the topology,
/// in words.
fn close(source: &Source<'_>, topology: &str) -> Result<Option<String>, ReadError> {
    let Some(run) = source.group.runs.first() else {
        return Ok(None);
    };
    let (mut close, mut all) = (0, 0);
    neighbours(run, |last, row| {
        all += 1;
        close += u64::from(row.t_arrive_ns.saturating_sub(last.t_arrive_ns) < STAMP_NS);
    })?;
    let close = analysis::statistics::share(close, all);
    Ok(close.map(|close| format!("{} on {topology}", number(close))))
}
