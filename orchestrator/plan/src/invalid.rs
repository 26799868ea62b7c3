//! What is wrong with an experiment, where, and what to do about it.

use std::ops::Range;

/// An experiment that cannot be run.
///
/// It keeps the place in the source, so that the cli can draw it; `Display` is the one-line form.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{origin}:{line}:{column}: {problem}{}{remedy}", if remedy.is_empty() { "" } else { "; " })]
pub struct InvalidFile {
    /// File name or other origin of the text.
    pub origin: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Bytes of the text that it is about; empty where it is about the whole.
    pub span: Range<usize>,
    /// What is wrong, with the value.
    pub problem: String,
    /// What to do; empty where the problem already says it.
    pub remedy: String,
}

impl InvalidFile {
    /// What is wrong at `span` of the text `source`, which is called `origin`.
    #[must_use]
    pub fn new(
        source: &str,
        origin: &str,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: &str,
    ) -> Self {
        let before = source.get(..span.start).unwrap_or("");
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        InvalidFile {
            origin: origin.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span,
            problem: problem.into(),
            remedy: remedy.to_owned(),
        }
    }
}
