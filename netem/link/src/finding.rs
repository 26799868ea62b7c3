//! Collects what is wrong with a profile's source, or odd, while it is read.

use std::ops::{Range, RangeInclusive};

use text::{DAY_NS, Diagnostic, InvalidQuantity, Severity, TomlText, duration_ns};
use toml::Spanned;

/// Collects the findings while a source is read.
pub(crate) struct Findings<'a> {
    pub(crate) source: TomlText<'a>,
    pub(crate) list: Vec<Diagnostic>,
}

impl<'a> Findings<'a> {
    pub(crate) fn new(text: &'a str, origin: &'a str) -> Self {
        Self {
            source: TomlText { text, origin },
            list: Vec::new(),
        }
    }

    pub(crate) fn error(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.list.push(self.source.error(span, message, remedy));
    }

    pub(crate) fn warning(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.list.push(self.source.warning(span, message, remedy));
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.list.iter().any(|f| f.severity == Severity::Error)
    }

    /// A time of up to a day, in ns; `None` after an error, which is recorded.
    pub(crate) fn duration_ns(&mut self, text: &Spanned<String>) -> Option<f64> {
        self.quantity(text, |text| time_ns(text, 0..=DAY_NS))
    }

    /// A time greater than zero, in ns.
    pub(crate) fn positive_ns(&mut self, text: &Spanned<String>) -> Option<f64> {
        self.quantity(text, |text| time_ns(text, 1..=DAY_NS))
    }

    /// A share as a fraction from 0 to 1.
    pub(crate) fn share(&mut self, text: &Spanned<String>) -> Option<f64> {
        self.quantity(text, text::share)
    }

    /// A rate greater than zero, in bit/s.
    pub(crate) fn rate_bps(&mut self, text: &Spanned<String>) -> Option<u64> {
        self.quantity(text, text::rate_bps)
    }

    fn quantity<T>(
        &mut self,
        text: &Spanned<String>,
        read: impl Fn(&str) -> Result<T, InvalidQuantity>,
    ) -> Option<T> {
        match read(text.get_ref()) {
            Ok(value) => Some(value),
            Err(why) => {
                self.error(text.span(), why.to_string(), why.remedy);
                None
            }
        }
    }
}

/// A time in a range up to a day. Anything longer is a mistake, and sums of a few such times are far below the limit
/// of a `u64` of nanoseconds.
fn time_ns(text: &str, range: RangeInclusive<u64>) -> Result<f64, InvalidQuantity> {
    duration_ns(text, range).map(|ns| ns as f64)
}
