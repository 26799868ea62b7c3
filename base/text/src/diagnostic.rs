//! What is wrong with a file, where, and what to do about it: one value and one line for files of every sort.
//!
//! Drawing it into the file's text, as compilers do, is the command line's.

use std::fmt;
use std::ops::{Range, RangeInclusive};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

use crate::duration;
use crate::field;
use crate::name::{self, is_name};
use crate::slip::Slip;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file cannot be used.
    Error,
    /// The file can be used, but its author may have meant something else.
    Warning,
}

/// What is wrong with a file, or odd, at its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// The key's dotted path, such as `both.delay.hold`; empty if it is about the whole text.
    pub field: String,
    /// What is wrong, with the value.
    pub problem: String,
    /// What to do about it; empty if the problem says it.
    pub remedy: Box<str>,
    /// File name or other origin of the text; empty if only the caller knows it.
    pub origin: Box<str>,
    /// Byte range of the text that it is about; empty if it is the whole text.
    pub span: Range<usize>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Diagnostic {
    /// Line, field and problem: for whoever reads another file, which names this one.
    #[must_use]
    pub fn inside(&self) -> String {
        match self.field.as_str() {
            "" => format!("line {}: {}", self.line, self.problem),
            field => format!("line {}, {field}: {}", self.line, self.problem),
        }
    }

    /// Field and problem: where the place is shown otherwise.
    #[must_use]
    pub fn title(&self) -> String {
        match self.field.as_str() {
            "" => self.problem.clone(),
            field => format!("{field}: {}", self.problem),
        }
    }
}

impl fmt::Display for Diagnostic {
    /// One line: `couva.toml:7:9: error: both.delay.hold: ...; ...`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.origin.is_empty() {
            write!(f, "{}:", self.origin)?;
        }
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        let title = self.title();
        write!(f, "{}:{}: {severity}: {title}", self.line, self.column)?;
        match &*self.remedy {
            "" => Ok(()),
            remedy => write!(f, "; {remedy}"),
        }
    }
}

impl std::error::Error for Diagnostic {}

/// A text that is being read, to give what is wrong its place.
#[derive(Debug, Clone, Copy)]
pub struct TomlText<'a> {
    /// The text.
    pub text: &'a str,
    /// Its name; empty if only the caller knows it.
    pub origin: &'a str,
}

impl TomlText<'_> {
    /// Reads the text as TOML.
    ///
    /// # Errors
    /// What is wrong at the first place that is not valid; `help` says where more is known of such files.
    pub fn read<T: DeserializeOwned>(&self, help: &str) -> Result<T, Diagnostic> {
        toml::from_str(self.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let slip = Slip::of(error.message(), self.text.get(span.clone()).unwrap_or(""));
            let mut field = field::at(self.text, &span);
            let (problem, remedy) = slip.words(&mut field, help);
            self.about(Severity::Error, field, span, problem, remedy)
        })
    }

    /// An error about the bytes `span`, with the key that they are under.
    pub fn error(
        &self,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnostic {
        let field = field::at(self.text, &span);
        self.about(Severity::Error, field, span, problem, remedy)
    }

    /// What is odd about the bytes `span`, with the key that they are under.
    pub fn warning(
        &self,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnostic {
        let field = field::at(self.text, &span);
        self.about(Severity::Warning, field, span, problem, remedy)
    }

    /// An error about a value.
    pub fn invalid<T>(
        &self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnostic {
        self.error(at.span(), problem, remedy)
    }

    /// A name, if it is [one](is_name).
    ///
    /// # Errors
    /// What is wrong with it, at its place.
    pub fn name(&self, name: &Spanned<String>) -> Result<String, Diagnostic> {
        let text = name.get_ref();
        if is_name(text) {
            return Ok(text.clone());
        }
        Err(self.invalid(name, format!("`{text}` is not a valid name"), name::REMEDY))
    }

    /// A time, in ns, that lies in `range`.
    ///
    /// # Errors
    /// What is wrong with it, at its place.
    pub fn duration_ns(
        &self,
        time: &Spanned<String>,
        range: RangeInclusive<u64>,
    ) -> Result<u64, Diagnostic> {
        duration::duration_ns(time.get_ref(), range)
            .map_err(|invalid| self.invalid(time, invalid.to_string(), invalid.remedy))
    }

    /// What is wrong with the key `field`, or odd, at the bytes `span`.
    fn about(
        &self,
        severity: Severity,
        field: String,
        span: Range<usize>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnostic {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        Diagnostic {
            severity,
            field,
            problem: problem.into(),
            remedy: remedy.into().into(),
            origin: self.origin.into(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span,
        }
    }
}
