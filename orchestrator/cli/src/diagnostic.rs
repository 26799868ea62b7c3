//! Draws on standard error what is wrong with a file, at its place, as compilers do.

use std::io::IsTerminal;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use text::is_active;
use text::plain;
use text::{Diagnostic, Severity};

/// Draws what is wrong with the text `source`, which is called `origin`, or odd.
pub(crate) fn draw(source: &str, origin: &str, found: &Diagnostic) {
    let level = match found.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    // A span that is not in the source would make the renderer panic.
    let span = if source.get(found.span.clone()).is_some() {
        found.span.clone()
    } else {
        0..0
    };
    // The places in it stay where they are.
    let source: String = source.chars().map(seen).collect();
    let title = found.title();
    let (origin, title, remedy) = (plain(origin), plain(&title), plain(&found.remedy));
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
