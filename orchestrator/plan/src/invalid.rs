//! What is wrong with an experiment, where, and what to do about it.

use std::ops::Range;

use endpoint::{DURATION_REMEDY, duration_ns};
use serde::de::DeserializeOwned;
use system::is_name;
use toml::Spanned;

/// An experiment that cannot be run.
///
/// It keeps the place in the source, so that the cli can show it; `Display` is the one-line form.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{origin}:{line}:{column}: {problem}{}{remedy}", if remedy.is_empty() { "" } else { "; " })]
pub struct InvalidFile {
    /// File name or other origin of the text.
    pub origin: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Range of bytes in the text that is wrong; empty if it is the whole text.
    pub span: Range<usize>,
    /// What is wrong, including the value.
    pub problem: String,
    /// What to do; empty if the problem already says it.
    pub remedy: String,
}

impl InvalidFile {
    /// An error at `span` of the text `source`, whose name is `origin`.
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

/// A text that is being read, to give errors their place.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a> {
    /// The text.
    pub source: &'a str,
    /// Its name in errors.
    pub origin: &'a str,
}

impl Reader<'_> {
    /// Parses the text as TOML.
    ///
    /// # Errors
    /// [`InvalidFile`], with `remedy`, at the first place that is not valid.
    pub fn parse<T: DeserializeOwned>(&self, remedy: &str) -> Result<T, InvalidFile> {
        toml::from_str(self.source).map_err(|error| {
            let place = Spanned::new(error.span().unwrap_or(0..0), ());
            self.invalid(&place, error.message(), remedy)
        })
    }

    /// An error at the place of `at`.
    pub fn invalid<T>(
        &self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: &str,
    ) -> InvalidFile {
        InvalidFile::new(self.source, self.origin, at.span(), problem, remedy)
    }

    /// Checks that a name can start a folder's name.
    ///
    /// # Errors
    /// [`InvalidFile`] if it cannot.
    pub fn name(&self, name: &Spanned<String>) -> Result<String, InvalidFile> {
        let text = name.get_ref();
        if is_name(text) {
            Ok(text.clone())
        } else {
            Err(self.invalid(
                name,
                format!("`{text}` is not a valid name of a results folder"),
                "use up to 40 of a-z, 0-9 and -",
            ))
        }
    }

    /// Parses a duration, ns.
    ///
    /// # Errors
    /// [`InvalidFile`] if it is not a duration.
    pub fn duration(&self, text: &Spanned<String>) -> Result<u64, InvalidFile> {
        duration_ns(text.get_ref()).map_err(|problem| self.invalid(text, problem, DURATION_REMEDY))
    }
}
