//! Errors and warnings about a profile's source, with their positions.

use std::ops::Range;

use toml::Spanned;

use crate::unit;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The profile cannot be played.
    Error,
    /// The profile can be played, but its author may have meant something else.
    Warning,
}

/// An error or an oddity in a profile's source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Its severity.
    pub severity: Severity,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
    /// The key's dotted path, such as `both.delay.hold`; empty if the source cannot be read far
    /// enough to know it.
    pub field: String,
    /// File name or other origin of the source.
    pub origin: String,
    /// Byte range of the source that it refers to.
    pub span: Range<usize>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// Line and column, both from 1, of a byte of `source`.
pub(crate) fn line_and_column(source: &str, byte: usize) -> (usize, usize) {
    let before = source.get(..byte).unwrap_or(source);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

impl std::fmt::Display for Finding {
    /// One line: `couva.toml:7:9: error: both.delay.hold: ...; ...`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(
            f,
            "{}:{}:{}: {severity}: ",
            self.origin, self.line, self.column
        )?;
        if !self.field.is_empty() {
            write!(f, "{}: ", self.field)?;
        }
        write!(f, "{}; {}", self.message, self.remedy)
    }
}

/// Collects the findings while a source is read.
pub(crate) struct Findings<'a> {
    source: &'a str,
    origin: &'a str,
    pub(crate) list: Vec<Finding>,
}

impl<'a> Findings<'a> {
    pub(crate) fn new(source: &'a str, origin: &'a str) -> Self {
        Self {
            source,
            origin,
            list: Vec::new(),
        }
    }

    pub(crate) fn error(
        &mut self,
        field: &str,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.push(Severity::Error, field, span, message.into(), remedy.into());
    }

    pub(crate) fn warning(
        &mut self,
        field: &str,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.push(
            Severity::Warning,
            field,
            span,
            message.into(),
            remedy.into(),
        );
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.list.iter().any(|f| f.severity == Severity::Error)
    }

    fn push(
        &mut self,
        severity: Severity,
        field: &str,
        span: Range<usize>,
        message: String,
        remedy: String,
    ) {
        let (line, column) = line_and_column(self.source, span.start);
        self.list.push(Finding {
            severity,
            message,
            remedy,
            field: field.to_owned(),
            origin: self.origin.to_owned(),
            span,
            line,
            column,
        });
    }

    /// A time in ns; `None` after an error, which is recorded.
    pub(crate) fn duration_ns(&mut self, field: &str, text: &Spanned<String>) -> Option<f64> {
        let remedy = "write a time of zero or more with its unit, such as \"10ms\" (ns, us, ms, s)";
        self.quantity(field, text, unit::duration_ns, remedy)
    }

    /// A time greater than zero, in ns.
    pub(crate) fn positive_ns(&mut self, field: &str, text: &Spanned<String>) -> Option<f64> {
        let value_ns = self.duration_ns(field, text)?;
        if value_ns == 0.0 {
            let remedy = "write a time of more than zero, such as \"10ms\"";
            self.error(field, text.span(), "this time is zero", remedy);
            return None;
        }
        Some(value_ns)
    }

    /// A share as a fraction from 0 to 1.
    pub(crate) fn share(&mut self, field: &str, text: &Spanned<String>) -> Option<f64> {
        let remedy = "write a share of 0 to 100 with its sign, such as \"0.8%\"";
        self.quantity(field, text, unit::share, remedy)
    }

    /// A rate greater than zero, in bit/s.
    pub(crate) fn rate_bps(&mut self, field: &str, text: &Spanned<String>) -> Option<u64> {
        let remedy = "write bits a second, such as \"1mbit\" (bit, kbit, mbit, gbit; tc's kbps \
                      means kilobytes a second and is not accepted)";
        self.quantity(field, text, unit::rate_bps, remedy)
    }

    fn quantity<T>(
        &mut self,
        field: &str,
        text: &Spanned<String>,
        parse: impl Fn(&str) -> Result<T, unit::InvalidQuantity>,
        remedy: &str,
    ) -> Option<T> {
        match parse(text.get_ref()) {
            Ok(value) => Some(value),
            Err(why) => {
                self.error(field, text.span(), why.to_string(), remedy);
                None
            }
        }
    }
}
