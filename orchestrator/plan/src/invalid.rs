//! An experiment's text, for the places of what is wrong with it.

use serde::de::DeserializeOwned;
use text::{Diagnostic, TomlText, WEEK_NS};
use toml::Spanned;

/// A value as written, with its place in the file.
pub(crate) type Word = Spanned<String>;

/// A text that is being read, to give errors their place.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a>(pub TomlText<'a>);

impl Reader<'_> {
    /// Parses the text as TOML.
    ///
    /// # Errors
    /// [`Diagnostic`] at the first place that is not valid; `help` is where more is known of such files.
    pub fn parse<T: DeserializeOwned>(&self, help: &str) -> Result<T, Diagnostic> {
        self.0.read(help)
    }

    /// An error at the place of `at`.
    pub fn invalid<T>(
        &self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: &str,
    ) -> Diagnostic {
        self.0.invalid(at, problem, remedy)
    }

    /// Checks that a name can start a folder's name.
    ///
    /// # Errors
    /// [`Diagnostic`] if it cannot.
    pub fn name(&self, name: &Spanned<String>) -> Result<String, Diagnostic> {
        self.0.name(name)
    }

    /// Parses the duration of a run, ns.
    ///
    /// # Errors
    /// [`Diagnostic`] if it is not a duration above zero and up to a week.
    pub fn duration(&self, text: &Spanned<String>) -> Result<u64, Diagnostic> {
        self.0.duration_ns(text, 1..=WEEK_NS)
    }
}
