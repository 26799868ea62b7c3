//! What is missing: damaged files, runs that are not complete, cells that were not run.

use analysis::{Campaign, Run, grouped};
use maud::{Markup, html};
use plan::Verdict;
use text::counted;

use super::badge;
use super::place::anchor;
use super::prose::kept;

use crate::called::called;
use crate::outcome::{OutcomeKind, without_folder};
use crate::report::Report;

pub(super) fn render(report: &Report<'_>) -> Option<Markup> {
    let campaign = report.campaign;
    let absent: Vec<&Run> = campaign.absent().collect();
    let bad: Vec<&Run> = campaign
        .runs
        .iter()
        .filter(|run| {
            !run.damage.is_empty() || run.verdict().is_some_and(|each| each != Verdict::Complete)
        })
        .collect();
    if report.damage.is_empty() && bad.is_empty() && absent.is_empty() {
        return None;
    }
    Some(html! {
        @if !report.damage.is_empty() { (damage(report)) }
        @if !bad.is_empty() { (incomplete(campaign, &bad)) }
        @if !absent.is_empty() { (never(campaign, &absent)) }
    })
}

fn damage(report: &Report<'_>) -> Markup {
    html! {
        div.notice.bad role="note" {
            h3 { "Damaged files" }
            p {
                "Nothing below uses the cells of these files; restore the files, or run the cells \
                 again."
            }
            ul {
                @for damage in &report.damage {
                    @let path = damage.path.strip_prefix(&report.campaign.folder).unwrap_or(&damage.path);
                    li { code { (path.display()) } ": " (damage.problem) }
                }
            }
        }
    }
}

/// Lists incomplete runs, grouped by verdict and reasons.
fn incomplete(campaign: &Campaign, runs: &[&Run]) -> Markup {
    let alike = grouped(runs, |run| (run.verdict(), reasons(campaign, run)));
    html! {
        div.notice.bad role="note" {
            h3 { (counted(runs.len(), "run that is", "runs that are")) " not complete" }
            p { "No table, figure or claim uses them." }
            @for ((verdict, reasons), runs) in &alike {
                details {
                    summary {
                        (counted(runs.len(), "run", "runs")) " " (badge::of_run(*verdict))
                        @for reason in reasons { " " span.reason { (reason) } }
                    }
                    ul.ids { @for run in runs { li { a href={ "#" (anchor(run)) } { (kept(&called(campaign, run))) } } } }
                }
            }
        }
    }
}

/// Why a run is not complete.
pub(super) fn reasons(campaign: &Campaign, run: &Run) -> Vec<String> {
    let own = run.manifest.iter().flat_map(|manifest| &manifest.reasons);
    let damage = run.damage.iter().map(ToString::to_string);
    own.cloned()
        .chain(damage)
        .map(|reason| without_folder(campaign, &reason))
        .collect()
}

fn never(campaign: &Campaign, runs: &[&Run]) -> Markup {
    html! {
        div.notice.quiet role="note" {
            h3 { (counted(runs.len(), "cell that was", "cells that were")) " " (badge::ended(OutcomeKind::NotRun)) }
            details {
                summary { "Which" }
                ul.ids { @for run in runs { li { (kept(&called(campaign, run))) } } }
            }
        }
    }
}
