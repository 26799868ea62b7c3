//! A system's text, for the positions of what is wrong with it, and the numbers in it.

use text::{Diagnostic, MINUTE_NS};
use toml::Spanned;

use crate::system::file::Each;

/// The text being read, for the positions of faults.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a>(pub(crate) &'a str);

impl Source<'_> {
    /// The text; only the caller knows its name.
    pub(crate) fn text(&self) -> text::TomlText<'_> {
        text::TomlText {
            text: self.0,
            origin: "",
        }
    }

    pub(crate) fn fault<T>(
        self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnostic {
        self.text().invalid(at, problem, remedy)
    }

    /// A finite number.
    pub(crate) fn finite(self, field: &str, value: &Spanned<f64>) -> Result<f64, Diagnostic> {
        match *value.get_ref() {
            x if x.is_finite() => Ok(x),
            x => Err(self.fault(value, format!("{field} is {x}"), "give a finite number")),
        }
    }

    /// A positive number, or a list of them, one for each input or output.
    pub(crate) fn positives(
        self,
        field: &str,
        value: &Spanned<Each>,
    ) -> Result<Vec<f64>, Diagnostic> {
        let numbers = value.get_ref().numbers();
        match numbers.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
            None => Ok(numbers.to_vec()),
            Some(x) => {
                Err(self.fault(value, format!("{field} is {x}"), "give a number above zero"))
            }
        }
    }

    /// A number above zero.
    pub(crate) fn positive(self, field: &str, value: &Spanned<f64>) -> Result<f64, Diagnostic> {
        match self.finite(field, value)? {
            x if x > 0.0 => Ok(x),
            x => Err(self.fault(value, format!("{field} is {x}"), "give a number above zero")),
        }
    }

    /// A time of at most a minute: anything longer is a typing error.
    pub(crate) fn span_ns(self, text: &Spanned<String>) -> Result<u64, Diagnostic> {
        self.text().duration_ns(text, 0..=MINUTE_NS)
    }
}
