//! What is expected of the runs, and whether they show it: a line for each clause and group.

use analysis::expect::{Answer, ClauseOutcome};
use maud::{Markup, html};

use super::badge::{Tone, badge};
use super::place::anchor_of;
use super::scroll::scroll;
use crate::report::Report;

/// `None` if nothing is expected.
pub(super) fn render(report: &Report<'_>) -> Option<Markup> {
    let judgement = &report.expectations;
    if judgement.is_empty() {
        return None;
    }
    let mut answers: Vec<&Answer> = judgement.answers.iter().collect();
    // What fails comes first.
    answers.sort_by_key(|answer| answer.outcome.holds());
    let lines = html! {
        table {
            thead { tr { th {} th { "runs" } th { "expected" } th { "found" } } }
            tbody {
                @for clause in &judgement.unasked {
                    tr {
                        td { (badge(Tone::Bad, "NOT MET")) }
                        td {} td { (clause) } td { "no run here has it" }
                    }
                }
                @for answer in answers {
                    tr {
                        td { (badge(tone(answer.outcome), answer.outcome.word())) }
                        td { (answer.group) }
                        td { (answer.clause) }
                        td { (answer.details()) (worst(report, answer)) }
                    }
                }
            }
        }
    };
    Some(html! {
        (scroll("What is expected", &lines))
        @for known in &judgement.passing {
            p { "The known failure of " code { (known.cells) } " passes: remove it from [[known]]." }
        }
    })
}

/// A link to the worst run.
fn worst(report: &Report<'_>, answer: &Answer) -> Markup {
    let cell = answer.shown.as_ref().map(|shown| shown.cell.as_str());
    let anchor = cell.and_then(|cell| anchor_of(report.campaign, cell));
    html! {
        @if let Some(anchor) = anchor { " " a href={ "#" (anchor) } { "See it" } }
    }
}

fn tone(outcome: ClauseOutcome) -> Tone {
    match outcome {
        ClauseOutcome::Met => Tone::Good,
        ClauseOutcome::NotMet => Tone::Bad,
        ClauseOutcome::NotTold { .. } | ClauseOutcome::Known => Tone::Mixed,
        ClauseOutcome::Unsupported => Tone::Quiet,
    }
}
