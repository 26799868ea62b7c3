//! Draws on standard error what is wrong with a file, at its place, as compilers do.

use std::io::IsTerminal;
use std::ops::Range;

use ::system::Fault;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use endpoint::plain;
use endpoint::plain::is_active;
use link::{Finding, Severity};
use plan::InvalidFile;

/// Draws every finding in a profile's source.
pub(crate) fn findings(source: &str, findings: &[Finding]) {
    for finding in findings {
        let field = if finding.field.is_empty() {
            String::new()
        } else {
            format!("{}: ", finding.field)
        };
        let title = format!("{field}{}", finding.message);
        draw(
            source,
            &finding.origin,
            finding.severity,
            &title,
            &finding.span,
            &finding.remedy,
        );
    }
}

/// Draws what is wrong with an experiment.
pub(crate) fn invalid(source: &str, invalid: &InvalidFile) {
    draw(
        source,
        &invalid.origin,
        Severity::Error,
        &invalid.problem,
        &invalid.span,
        &invalid.remedy,
    );
}

/// Draws what is wrong with a system.
pub(crate) fn fault(source: &str, origin: &str, fault: &Fault) {
    draw(
        source,
        origin,
        Severity::Error,
        &fault.problem,
        &fault.span,
        &fault.remedy,
    );
}

fn draw(
    source: &str,
    origin: &str,
    severity: Severity,
    title: &str,
    span: &Range<usize>,
    remedy: &str,
) {
    let level = match severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    // A span that is not in the source would make the renderer panic.
    let span = if source.get(span.clone()).is_some() {
        span.clone()
    } else {
        0..0
    };
    // The places in it stay where they are.
    let source: String = source.chars().map(seen).collect();
    let (origin, title, remedy) = (plain(origin), plain(title), plain(remedy));
    let snippet = Snippet::source(source)
        .path(&*origin)
        .annotation(AnnotationKind::Primary.span(span));
    let mut group = level.primary_title(&*title).element(snippet);
    if !remedy.is_empty() {
        group = group.element(Level::HELP.message(&*remedy));
    }
    let colours = std::io::stderr().is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let renderer = if colours {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    crate::console::drawn(&format!("{}\n", renderer.render(&[group])));
}

/// A character that is only seen, as long in bytes as this one.
fn seen(letter: char) -> char {
    match letter.len_utf8() {
        _ if letter == '\r' || !is_active(letter) => letter,
        1 => '?',
        2 => '\u{bf}',
        _ => '\u{fffd}',
    }
}
