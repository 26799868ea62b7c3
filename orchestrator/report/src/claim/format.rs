//! The claims as files: `claims.json` with everything, `claims.csv` with a row for each part.

use serde::Serialize;

use super::{Finding, Verdict};

/// `claims.json`: the findings in order. A number that is not finite is null.
#[must_use]
pub fn to_json(findings: &[Finding]) -> String {
    // Plain data of strings and numbers: serialising it cannot fail.
    serde_json::to_string_pretty(findings).unwrap_or_default() + "\n"
}

/// One part of a finding as a row. Shares are from 0 to 1. An empty field was not measured, is not in
/// the paper, or is an open end; `inf` is a step that never settled.
#[derive(Debug, Serialize)]
struct Row<'a> {
    id: &'a str,
    place: &'a str,
    claim: &'a str,
    check: &'a str,
    verdict: Verdict,
    of: &'a str,
    unit: &'a str,
    paper: Option<f64>,
    ours: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
    n: Option<u64>,
    accepted_low: Option<f64>,
    accepted_high: Option<f64>,
    part_verdict: Option<Verdict>,
    reason: &'a str,
}

/// `claims.csv`: a row for each part, and one for a claim without any.
#[must_use]
pub fn to_csv(findings: &[Finding]) -> String {
    analysis::csv(findings.iter().flat_map(rows))
}

fn rows(finding: &Finding) -> Vec<Row<'_>> {
    let whole = || Row {
        id: finding.id,
        place: finding.place,
        claim: finding.claim,
        check: &finding.check,
        verdict: finding.verdict,
        of: "",
        unit: "",
        paper: None,
        ours: None,
        low: None,
        high: None,
        n: None,
        accepted_low: None,
        accepted_high: None,
        part_verdict: None,
        reason: &finding.reason,
    };
    if finding.parts.is_empty() {
        return vec![whole()];
    }
    let finite = |x: f64| x.is_finite().then_some(x);
    let parts = finding.parts.iter();
    let rows = parts.map(|part| Row {
        of: &part.of,
        unit: part.unit,
        paper: part.paper,
        ours: part.ours.map(|ours| ours.value),
        low: part.ours.map(|ours| ours.low),
        high: part.ours.map(|ours| ours.high),
        n: part.ours.map(|ours| ours.n),
        accepted_low: part.accepted.and_then(|(low, _)| finite(low)),
        accepted_high: part.accepted.and_then(|(_, high)| finite(high)),
        part_verdict: Some(part.verdict),
        ..whole()
    });
    rows.collect()
}
