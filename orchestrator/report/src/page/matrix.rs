//! The top of the page: the answer in words, and as a table of loops.

use maud::{Markup, html};
use plan::{Client, Plan};

use super::badge::{badge, tone_of};
use super::scroll::scroll;
use crate::answer::{Answer, Row, Standing, Survival};
use crate::number::{duration, significant};

pub(super) fn render(answer: &Answer, plan: &Plan) -> Markup {
    let words = answer.words();
    let tone = answer
        .survival()
        .map_or("quiet", |survival| tone_of(survival).class());
    html! {
        header.answer.(tone) {
            p.origin { "webloop report · experiment " b { (plan.experiment) } " · seed " (plan.seed) }
            h1 { (words.first().map_or("", String::as_str)) }
            @for sentence in words.iter().skip(1) { p.lead { (sentence) } }
            p.about { "The experiment: " (plan.about) }
        }
        @if !answer.rows.is_empty() { (scroll("Where the loop survives", &table(answer))) (legend(answer)) }
    }
}

fn table(answer: &Answer) -> Markup {
    html! {
        table.matrix {
            caption {
                "Where the loop survives: stable runs of complete ones, and median settling"
                @if answer.simulated { ", simulated" }
            }
            thead {
                tr {
                    th scope="col" { "client" }
                    th scope="col" { "rate" }
                    @for topology in &answer.topologies { th scope="col" { (topology) } }
                }
            }
            @for rows in answer.rows.chunk_by(|one, other| one.client == other.client && one.setup == other.setup) {
                tbody {
                    @for (at, row) in rows.iter().enumerate() {
                        tr {
                            @if at == 0 {
                                th scope="rowgroup" rowspan=(rows.len()) { (client(row)) }
                            }
                            th.rate scope="row" { (row.rate) }
                            @for standing in &row.standings { (entry(standing.as_ref())) }
                        }
                    }
                }
            }
        }
    }
}

fn client(row: &Row) -> Markup {
    html! {
        (row.client)
        @if !row.is_usual() || row.client.is_browser() { span.setup { (row.setup) } }
    }
}

fn entry(standing: Option<&Standing>) -> Markup {
    let Some(standing) = standing else {
        return html! { td.none { span aria-hidden="true" { "·" } span.unseen { "not planned" } } };
    };
    let survival = standing.survival();
    let word = match survival {
        Survival::Unknown => "not run".to_owned(),
        _ => format!("{} of {}", standing.stable, standing.complete),
    };
    html! {
        td.(tone_of(survival).class()) {
            (badge(tone_of(survival), &word))
            @if standing.unstable > 0 { span.fine { (standing.unstable) " unstable" } }
            @if standing.not_settled > 0 { span.fine { (standing.not_settled) " not settled" } }
            @if let Some(settling) = standing.settling_ms {
                span.settling { (duration(settling.value)) }
            } @else if survival != Survival::Unknown {
                span.settling { "not settled" }
            }
            @if !standing.times.is_empty() {
                span.fine {
                    @for (at, times) in standing.times.iter().enumerate() {
                        @if at > 0 { ", " }
                        span { (significant(times.factor, 2)) "× " (times.of) }
                    }
                }
            }
            @if standing.complete < standing.planned && survival != Survival::Unknown {
                span.fine { (standing.planned - standing.complete) " of " (standing.planned) " missing" }
            }
        }
    }
}

fn legend(answer: &Answer) -> Markup {
    let times = |of: Client| {
        answer
            .loops()
            .any(|(_, _, standing)| standing.times.iter().any(|times| times.of == of))
    };
    html! {
        p.legend {
            "Settling is into 2 % of the reference, the median of the complete runs; one that never \
             settled counts as later than any."
            @if let Some(reference) = &answer.reference {
                @if Client::YARDSTICKS.into_iter().any(times) {
                    " × native, × python: divided by that client’s median on " (reference)
                    ", without a network, at the same rate."
                }
            }
        }
    }
}
