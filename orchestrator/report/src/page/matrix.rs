//! The top of the page: the answer in words, and as a table of loops.

use analysis::LoopVerdict;
use maud::{Markup, html};
use plan::{Client, Plan};
use text::significant;

use super::badge::{Tone, badge, ended, signed};
use super::prose::{NO_BREAK, kept};
use super::scroll::scroll;
use crate::answer::{Answer, Row, Standing, Survival};
use crate::number::duration;
use crate::outcome::OutcomeKind;

/// The answer in one line, over the picture.
pub(super) fn headline(answer: &Answer, plan: &Plan) -> Markup {
    let words = answer.words();
    let tone = tone_of_all(answer).class();
    html! {
        header.answer.(tone) {
            p.origin { "webloop report · experiment " b { (plan.experiment) } " · seed " (plan.seed) }
            h1 { (kept(words.first().map_or("", String::as_str))) }
        }
    }
}

/// The rest of the answer: sentences, and a table of loops.
pub(super) fn render(answer: &Answer, plan: &Plan) -> Markup {
    let words = answer.words();
    html! {
        div.leads {
            @for sentence in words.iter().skip(1) { p.lead { (kept(sentence)) } }
            @if !plan.about.is_empty() { p.about { "The experiment: " (kept(&plan.about)) } }
        }
        @if !answer.rows.is_empty() {
            p.caption #matrix-caption {
                "Runs that hold well, of complete ones; median settling, and overshoot"
                @if answer.simulated { ", simulated" }
            }
            (scroll("Where the loop holds", &table(answer)))
            (legend(answer))
        }
    }
}

fn tone_of_all(answer: &Answer) -> Tone {
    let complete = || {
        answer
            .loops()
            .filter(|(_, _, standing)| standing.complete > 0)
    };
    let is = |tone: Tone| complete().all(|(_, _, standing)| tone_of(standing) == tone);
    if complete().next().is_none() {
        Tone::Quiet
    } else if is(Tone::Good) {
        Tone::Good
    } else if is(Tone::Bad) {
        Tone::Bad
    } else {
        Tone::Mixed
    }
}

/// How good the news of a loop is: an overshoot of more than the step itself is none, even if it is held.
fn tone_of(standing: &Standing) -> Tone {
    match standing.survival() {
        Survival::Unknown => Tone::Quiet,
        Survival::Always if !is_wild(standing) => Tone::Good,
        _ if !is_held_by_some(standing) => Tone::Bad,
        _ => Tone::Mixed,
    }
}

/// Whether some of its runs hold: of one that always fails, the verdict says all.
fn is_held_by_some(standing: &Standing) -> bool {
    standing.verdicts[..2].iter().any(|count| *count > 0)
}

/// Whether it overshoots by more than the step.
fn is_wild(standing: &Standing) -> bool {
    standing.overshoot_pct.is_some_and(|pct| pct > 100.0)
}

fn table(answer: &Answer) -> Markup {
    html! {
        // The style sheet gives each topology room for its words, and no more, so that few fit on a telephone.
        table.matrix aria-describedby="matrix-caption" style=(format!("--places: {}", answer.topologies.len())) {
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
    let is_known = standing.complete > 0;
    let word = format!("{} of {}", standing.holds, standing.complete);
    html! {
        td.(tone_of(standing).class()) {
            @if is_known { (badge(tone_of(standing), &word)) }
            @for (verdict, count) in LoopVerdict::ALL.iter().zip(standing.verdicts).skip(1) {
                @if count > 0 { span.fine { (count) (NO_BREAK) (verdict) } }
            }
            @if let Some(settling) = standing.settling_ms {
                span.settling { (kept(&duration(settling.value))) }
            } @else if let Some(kept) = standing.kept {
                span.settling { (kept) }
            } @else if is_held_by_some(standing) {
                span.settling { "no median settling" }
            }
            @if let Some(pct) = standing.overshoot_pct.filter(|pct| *pct >= 0.5) {
                span.fine.wild[is_wild(standing)] { (kept(&format!("overshoot {pct:.0} %"))) }
            }
            @if !standing.times.is_empty() {
                span.fine {
                    @for (at, times) in standing.times.iter().enumerate() {
                        @if at > 0 { ", " }
                        span { (significant(times.factor, 2)) "× " (times.of) }
                    }
                }
            }
            @for (kind, count) in &standing.others { (other(standing, *kind, *count)) }
        }
    }
}

/// How many runs ended otherwise than complete: with a sign, where nothing else is there.
fn other(standing: &Standing, kind: OutcomeKind, count: usize) -> Markup {
    let tone = match kind {
        OutcomeKind::Complete | OutcomeKind::NotRun => Tone::Quiet,
        OutcomeKind::Disturbed | OutcomeKind::Unsupported => Tone::Mixed,
        OutcomeKind::Invalid | OutcomeKind::Failed | OutcomeKind::Damaged => Tone::Bad,
    };
    html! {
        @if standing.complete > 0 {
            span.fine { (count) (NO_BREAK) (ended(kind)) }
        } @else {
            span.other { (signed(tone, &html! { (count) (NO_BREAK) (ended(kind)) })) }
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
            "Settling is into " (kept("2 %")) " of the reference, or the band that the system asks for: the median of the complete runs; one that never \
             settled counts as later than any. Overshoot is their median in parts of the step; beyond 100" (NO_BREAK) "% it is amber."
            @if let Some(reference) = &answer.reference {
                @if Client::YARDSTICKS.into_iter().any(times) {
                    " × native, × python: divided by that client’s median on " (reference)
                    ", without a network, at the same rate."
                }
            }
        }
    }
}
