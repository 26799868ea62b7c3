//! The claims board: each claim of the paper with its verdict, the numbers and the runs behind it.

use maud::{Markup, html};
use text::counted;
use text::significant;

use super::badge::of_claim;
use super::place::anchor_of;
use super::scroll::scroll;

use crate::claim::{Finding, Part, Verdict};
use crate::group::Estimate;
use crate::number::brief;
use crate::outcome::answered;
use crate::report::Report;

/// In the order of the filter's buttons.
const VERDICTS: [Verdict; 4] = [
    Verdict::Agrees,
    Verdict::Differs,
    Verdict::CannotBeTold,
    Verdict::NotRun,
];

pub(super) fn render(report: &Report<'_>) -> Option<Markup> {
    let findings = &report.claims;
    if findings.is_empty() {
        return None;
    }
    let (strict, readings): (Vec<&Finding>, Vec<&Finding>) = findings
        .iter()
        .partition(|finding| finding.reading_of.is_none());
    Some(html! {
        (filter(&strict))
        div #board.board {
            @for finding in strict { (card(report, finding)) }
        }
        @if !readings.is_empty() {
            p {
                b { "Readings. " }
                "Claims under settings, or readings of the same rows, that the paper's text allows \
                 but does not state. They are not counted above."
            }
            div #readings.board {
                @for finding in readings { (card(report, finding)) }
            }
        }
    })
}

fn count(findings: &[&Finding], verdict: Verdict) -> usize {
    let is = |finding: &&&Finding| finding.verdict == verdict;
    findings.iter().filter(is).count()
}

/// A verdict as a word for programs.
fn key(verdict: Verdict) -> String {
    answered(verdict).replace(' ', "-")
}

/// A verdict as a verb for this number of claims.
fn said_of(verdict: Verdict, n: usize) -> &'static str {
    match (verdict, n) {
        (Verdict::Agrees, 1) => "agrees",
        (Verdict::Agrees, _) => "agree",
        (Verdict::Differs, 1) => "differs",
        (Verdict::Differs, _) => "differ",
        (Verdict::CannotBeTold, 1) => "is undecided",
        (Verdict::CannotBeTold, _) => "are undecided",
        (Verdict::NotRun, 1) => "was not run",
        (Verdict::NotRun, _) => "were not run",
    }
}

fn filter(findings: &[&Finding]) -> Markup {
    let present: Vec<Verdict> = VERDICTS
        .into_iter()
        .filter(|verdict| count(findings, *verdict) > 0)
        .collect();
    html! {
        p {
            "Of " (counted(findings.len(), "claim", "claims")) ": "
            @for (at, verdict) in present.iter().enumerate() {
                @if at > 0 { ", " }
                (count(findings, *verdict)) " " (said_of(*verdict, count(findings, *verdict)))
            }
            ". Verdicts are computed from the runs, within the limits that each claim states."
        }
        div.filter.needs-script role="group" aria-label="Show claims by verdict" {
            button type="button" data-show="" aria-pressed="true" { "all " (findings.len()) }
            @for verdict in &present {
                button type="button" data-show=(key(*verdict)) aria-pressed="false" {
                    (answered(*verdict)) " " (count(findings, *verdict))
                }
            }
        }
        p #shown.unseen role="status" {}
    }
}

fn card(report: &Report<'_>, finding: &Finding) -> Markup {
    let id = format!("claim-{}", finding.id);
    html! {
        article.claim id=(id) data-verdict=(key(finding.verdict)) aria-labelledby={ (id) "-claim" } {
            p.place { (finding.place) @if let Some(of) = finding.reading_of { ", a reading of " (of) } }
            div {
                p.verdict { (of_claim(finding.verdict)) }
                h3 id={ (id) "-claim" } { (finding.claim) }
                @if let Some(part) = finding.parts.first() { (headline(part)) }
                p.reason { (finding.reason) }
                details {
                    summary {
                        "Check, numbers and runs"
                        span.fine {
                            (counted(finding.parts.len(), "number", "numbers")) ", "
                            (counted(finding.runs.len(), "run", "runs"))
                        }
                    }
                    p { b { "Agrees if: " } (finding.check) }
                    @if !finding.parts.is_empty() { (scroll("Numbers of the claim", &numbers(finding))) }
                    @if !finding.runs.is_empty() { (runs(report, finding)) }
                    p.fine { "In claims.json: " code { (finding.id) } }
                }
            }
        }
    }
}

/// The first number, which is what the claim is about.
fn headline(part: &Part) -> Markup {
    if part.paper.is_none() && part.ours.is_none() {
        return html! {};
    }
    html! {
        dl.numbers {
            @if let Some(paper) = part.paper {
                div { dt { "paper" } dd { (with_unit(&brief(paper), part.unit)) } }
            }
            div {
                dt { "here" }
                dd {
                    @match part.ours {
                        Some(ours) => { (with_unit(&significant(ours.value, 3), part.unit)) " " span.fine { (interval(&ours)) } }
                        None => { "not run" }
                    }
                }
            }
            div { dt { "of" } dd { (part.of) } }
        }
    }
}

fn numbers(finding: &Finding) -> Markup {
    html! {
        table {
            caption { "What was measured" }
            thead {
                tr {
                    th scope="col" { "of" }
                    th.number scope="col" { "paper" }
                    th.number scope="col" { "here" }
                    th scope="col" { "interval" }
                    th scope="col" { "accepted" }
                    th scope="col" { "verdict" }
                }
            }
            tbody {
                @for part in &finding.parts {
                    tr {
                        th scope="row" { (part.of) }
                        td.number { (part.paper.map_or_else(|| "–".to_owned(), |x| with_unit(&brief(x), part.unit))) }
                        td.number { (part.ours.map_or_else(|| "–".to_owned(), |ours| with_unit(&significant(ours.value, 3), part.unit))) }
                        td { (part.ours.map_or_else(|| "–".to_owned(), |ours| interval(&ours))) }
                        td { (part.accepted.map_or_else(|| "–".to_owned(), accepted)) }
                        td { (of_claim(part.verdict)) }
                    }
                }
            }
        }
    }
}

fn runs(report: &Report<'_>, finding: &Finding) -> Markup {
    html! {
        p.fine { "Runs:" }
        ul.ids {
            @for id in &finding.runs {
                li {
                    @match anchor_of(report.campaign, id) {
                        Some(anchor) => { a href={ "#" (anchor) } { (id) } }
                        None => { (id) }
                    }
                }
            }
        }
    }
}

fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        unit => format!("{number} {unit}"),
    }
}

/// `9.4 to 10.3, n = 7`; without an interval `n = 3`.
fn interval(estimate: &Estimate) -> String {
    let n = format!("n = {}", estimate.n);
    if estimate.low == estimate.high || !estimate.has_interval() {
        n
    } else {
        format!("{} to {}, {n}", end(estimate.low), end(estimate.high))
    }
}

/// An end of an interval. It is infinite if some of the runs never settled.
fn end(x: f64) -> String {
    if x.is_infinite() {
        "∞".to_owned()
    } else {
        significant(x, 3)
    }
}

fn accepted((low, high): (f64, f64)) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) if low == high => brief(low),
        (true, true) => format!("{} to {}", brief(low), brief(high)),
        (true, false) => format!("at least {}", brief(low)),
        (false, true) => format!("at most {}", brief(high)),
        (false, false) => "any".to_owned(),
    }
}
