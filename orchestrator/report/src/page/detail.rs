//! Everything about one run.

use std::fmt::Write as _;

use analysis::{Campaign, Run};
use link::certificate::{Certificate, Verdict};
use maud::{Markup, html};
use record::Manifest;
use serde::Serialize;

use super::gap::reasons;
use super::leaf::leaves;
use super::place::was_made;
use crate::number::{duration, percent};

pub(super) fn render(campaign: &Campaign, run: &Run) -> Markup {
    let cell = &run.cell;
    html! {
        div.detail {
            p.id {
                code { (cell.id) }
                @if was_made(run) { " " a href={ "../cells/" (cell.id) "/" } { "its folder" } }
            }
            @for reason in reasons(campaign, run) { p.reason { (reason) } }
            @if let Some(manifest) = &run.manifest { (made(manifest)) }
        }
    }
}

/// The settings that all repeats of a run share.
pub(super) fn settings(run: &Run) -> Markup {
    let cell = &run.cell;
    let mut lines = vec![(
        "duration".to_owned(),
        duration(cell.duration_ns as f64 / 1e6),
    )];
    lines.extend(leaves(&cell.settings));
    if let Some(page) = &cell.page {
        lines.extend(leaves(page));
    }
    list(&lines)
}

fn made(manifest: &Manifest) -> Markup {
    html! {
        (list(&[
            ("link seed".to_owned(), manifest.cell.link_seed.to_string()),
            ("started".to_owned(), to_the_second(&manifest.started)),
            ("took".to_owned(), duration(manifest.wall_s * 1e3)),
            ("back-end".to_owned(), manifest.backend.clone()),
            ("player".to_owned(), manifest.player.clone()),
        ]))
        @if let Some(certificate) = &manifest.certificate { (proof(certificate)) }
        @if let Some(messages) = &manifest.messages {
            h4 { "What its messages say about the link" }
            (lines(messages))
        }
        @if !manifest.earlier.is_empty() {
            h4 { "Earlier tries, which were disturbed" }
            @for reason in &manifest.earlier { p.reason { (reason) } }
        }
        @if let Some(page) = &manifest.page {
            h4 { "The page's own report" }
            (lines(page))
        }
        @if let Some(controller) = &manifest.controller {
            h4 { "The controller's own report" }
            (lines(controller))
        }
        @if !manifest.files.is_empty() {
            h4 { "Files, by SHA-256" }
            pre { (checksums(manifest)) }
        }
    }
}

/// A time without its fraction of a second: `2026-11-21T15:04:37Z`.
fn to_the_second(time: &str) -> String {
    match time.split_once('.') {
        Some((whole, fraction)) if fraction.ends_with('Z') => format!("{whole}Z"),
        _ => time.to_owned(),
    }
}

/// The values of a report, one per line. Its settings are left out, since they are shown above, and
/// so are a browser's arguments, which are these settings with paths of the machine.
fn lines(report: &impl Serialize) -> Markup {
    const REPEATED: [&str; 4] = ["settings.", "browser.arguments", "start_ns", "stop_ns"];
    let mut text = String::new();
    for (name, value) in leaves(report) {
        if !REPEATED.iter().any(|repeated| name.starts_with(repeated)) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name} {value}");
        }
    }
    html! { pre.lines { (text) } }
}

fn proof(certificate: &Certificate) -> Markup {
    let (measured, predicted) = (certificate.measured, certificate.predicted);
    let residual = certificate.residuals.rtt;
    html! {
        h4 { "Certificate of the link" }
        p {
            @if certificate.verdict == Verdict::Holds { "Holds" } @else { "Does not hold" }
            ": " (certificate.answered) " of " (certificate.sent) " echoes answered"
            @if measured.times_ms().is_some() {
                ", mean RTT " (duration(measured.avg_ms))
                @if predicted.times_ms().is_some() {
                    " where the link had " (duration(predicted.avg_ms))
                }
            }
            ", loss " (percent(measured.loss)) " where it had " (percent(predicted.loss))
            @if measured.times_ms().is_some() {
                "; from " (duration(measured.min_ms)) " to " (duration(measured.max_ms))
                ", sd " (duration(measured.sd_ms))
                "; off by " (duration(residual.median_ms)) " in the median, 99 % by less than "
                (duration(residual.p99_ms)) ", at most by " (duration(residual.max_ms))
                ", on average by " (duration(residual.bias_ms))
            }
            "."
        }
    }
}

/// The checksums in the form that `sha256sum --check` reads.
fn checksums(manifest: &Manifest) -> String {
    let mut text = String::new();
    for (name, fact) in manifest.files.iter().filter(|(_, fact)| fact.bytes > 0) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}  {name}", fact.sha256);
    }
    text
}

fn list(lines: &[(String, String)]) -> Markup {
    html! {
        dl.facts {
            @for (name, value) in lines { div { dt { (name) } dd { (value) } } }
        }
    }
}
