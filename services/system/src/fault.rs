//! A fault in a system's text, with its position.

use std::ops::Range;

use toml::Spanned;

use crate::file::Each;

/// Why a text does not describe a system.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {problem}; {remedy}")]
pub struct Fault {
    /// What is wrong, with the value.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
    /// Byte range of the text that it refers to.
    pub span: Range<usize>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Fault {
    pub(crate) fn new(
        source: &str,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let before = source.get(..span.start).unwrap_or(source);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        Self {
            problem: problem.into(),
            remedy: remedy.into(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span,
        }
    }
}

/// The text being read, for the positions of faults.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a>(pub(crate) &'a str);

impl Source<'_> {
    pub(crate) fn fault<T>(
        self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Fault {
        Fault::new(self.0, at.span(), problem, remedy)
    }

    /// A finite number.
    pub(crate) fn finite(self, field: &str, value: &Spanned<f64>) -> Result<f64, Fault> {
        match *value.get_ref() {
            x if x.is_finite() => Ok(x),
            x => Err(self.fault(value, format!("{field} is {x}"), "give a finite number")),
        }
    }

    /// A positive number, or a list of them, one for each input or output.
    pub(crate) fn positives(self, field: &str, value: &Spanned<Each>) -> Result<Vec<f64>, Fault> {
        let numbers = value.get_ref().numbers();
        match numbers.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
            None => Ok(numbers.to_vec()),
            Some(x) => {
                Err(self.fault(value, format!("{field} is {x}"), "give a number above zero"))
            }
        }
    }

    /// A number above zero.
    pub(crate) fn positive(self, field: &str, value: &Spanned<f64>) -> Result<f64, Fault> {
        match self.finite(field, value)? {
            x if x > 0.0 => Ok(x),
            x => Err(self.fault(value, format!("{field} is {x}"), "give a number above zero")),
        }
    }

    /// A time of at most a minute: anything longer is a typing error.
    pub(crate) fn span_ns(self, field: &str, text: &Spanned<String>) -> Result<u64, Fault> {
        const LONGEST_NS: u64 = 60_000_000_000;
        endpoint::span::span_ns(text.get_ref())
            .filter(|ns| *ns <= LONGEST_NS)
            .ok_or_else(|| {
                self.fault(
                    text,
                    format!("{field} is `{}`", text.get_ref()),
                    "write a time from 0ms to 60s with its unit, such as \"25ms\"",
                )
            })
    }
}
