//! Shares and rates: a number and its unit. `duration` has times; both read numbers alike.

use std::fmt;

use crate::span::{DAY_NS, MINUTE_NS, WEEK_NS, duration_text};

/// How to write a share.
const SHARE: &str = "write a share of 0 to 100 with its sign, such as \"0.8%\"";
/// How to write a rate.
const RATE: &str = "write bits a second, such as \"1mbit\" (bit, kbit, mbit, gbit; tc's kbps means kilobytes a \
                    second and is not accepted)";
/// Greatest rate.
const FASTEST_BPS: f64 = 1e12;

/// A text that is not the expected quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InvalidQuantity {
    /// The text as given.
    pub text: String,
    /// What is wrong with it.
    pub flaw: Flaw,
    /// How to write such a quantity.
    pub remedy: &'static str,
}

/// What is wrong with a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flaw {
    /// It does not begin with a number.
    NotANumber,
    /// There is nothing behind the number.
    NoUnit,
    /// It has a unit of something else.
    UnknownUnit,
    /// It is below zero.
    Negative,
    /// A time of zero, where none can be.
    Zero,
    /// A time that is not a whole number of nanoseconds, where it has to be.
    NotWhole,
    /// A time above this many ns.
    TooLong(u64),
    /// A rate that no link has.
    TooFast,
    /// It lies outside 0 % to 100 %.
    NotAShare,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotANumber => "is not a number with a unit",
            Self::NoUnit => "has no unit",
            Self::UnknownUnit => "has an unknown unit",
            Self::Negative => "is negative",
            Self::Zero => "is zero",
            Self::NotWhole => "is not a whole number of nanoseconds",
            Self::TooLong(MINUTE_NS) => "is longer than a minute",
            Self::TooLong(DAY_NS) => "is longer than a day",
            Self::TooLong(WEEK_NS) => "is longer than a week",
            Self::TooLong(longest_ns) => {
                return write!(f, "is longer than {}", duration_text(*longest_ns));
            }
            Self::TooFast => "is more than 1 Tbit/s",
            Self::NotAShare => "lies outside 0 % to 100 %",
        })
    }
}

impl fmt::Display for InvalidQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` {}", self.text, self.flaw)
    }
}

impl std::error::Error for InvalidQuantity {}

impl InvalidQuantity {
    pub(crate) fn new(text: &str, flaw: Flaw, remedy: &'static str) -> Self {
        Self {
            text: text.to_owned(),
            flaw,
            remedy,
        }
    }
}

/// A rate such as `1mbit`, in bit/s.
///
/// # Errors
/// [`InvalidQuantity`] if it is not a rate, is negative, or is more than 1 Tbit/s.
pub fn rate_bps(text: &str) -> Result<u64, InvalidQuantity> {
    let bps = one(text).and_then(|(number, unit)| {
        let scale = match unit {
            "bit" => 1.0,
            "kbit" => 1e3,
            "mbit" => 1e6,
            "gbit" => 1e9,
            _ => return Err(Flaw::UnknownUnit),
        };
        match number * scale {
            bps if bps > FASTEST_BPS => Err(Flaw::TooFast),
            bps => Ok(bps.round() as u64),
        }
    });
    bps.map_err(|flaw| InvalidQuantity::new(text, flaw, RATE))
}

/// A share such as `0.8%`, as a part of 1.
///
/// # Errors
/// [`InvalidQuantity`] if it is not a share of 0 to 100 %.
pub fn share(text: &str) -> Result<f64, InvalidQuantity> {
    let part = one(text).and_then(|(number, unit)| match unit {
        "%" if number <= 100.0 => Ok(number / 100.0),
        "%" => Err(Flaw::NotAShare),
        _ => Err(Flaw::UnknownUnit),
    });
    part.map_err(|flaw| InvalidQuantity::new(text, flaw, SHARE))
}

/// The number and the unit of a text that has one of each.
fn one(text: &str) -> Result<(f64, &str), Flaw> {
    let part = Term::first(text)?;
    if !part.after.is_empty() {
        return Err(Flaw::UnknownUnit);
    }
    let number: f64 = part.number.parse().map_err(|_| Flaw::NotANumber)?;
    if number.is_finite() {
        Ok((number, part.unit))
    } else {
        Err(Flaw::NotANumber)
    }
}

/// A number of zero or more and the unit behind it.
pub(crate) struct Term<'a> {
    /// Digits, with a point and an exponent if there are any.
    pub(crate) number: &'a str,
    pub(crate) unit: &'a str,
    /// What follows.
    pub(crate) after: &'a str,
}

impl<'a> Term<'a> {
    /// The part that a text begins with.
    pub(crate) fn first(text: &'a str) -> Result<Self, Flaw> {
        let text = text.trim();
        if let Some(rest) = text.strip_prefix('-') {
            let is_number = rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
            return Err(if is_number {
                Flaw::Negative
            } else {
                Flaw::NotANumber
            });
        }
        let text = text.strip_prefix('+').unwrap_or(text);
        let is_of_unit = |(at, c): (usize, char)| {
            // The e of "1e3ms" belongs to the number, and the sign behind it; an e in a unit does not.
            let follows = &text[at + c.len_utf8()..];
            let is_exponent = matches!(c, 'e' | 'E')
                && follows.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+');
            let is_sign = matches!(c, '-' | '+') && text[..at].ends_with(['e', 'E']);
            !(c.is_ascii_digit() || c == '.' || is_exponent || is_sign)
        };
        let unit_at = text
            .char_indices()
            .find(|at| is_of_unit(*at))
            .map_or(text.len(), |(at, _)| at);
        let (number, rest) = text.split_at(unit_at);
        if !number.contains(|c: char| c.is_ascii_digit()) {
            return Err(Flaw::NotANumber);
        }
        let rest = rest.trim_start();
        let ends =
            |c: char| c.is_ascii_digit() || c.is_whitespace() || matches!(c, ',' | '-' | '+' | '.');
        let (unit, after) = rest.split_at(rest.find(ends).unwrap_or(rest.len()));
        if unit.is_empty() {
            return Err(Flaw::NoUnit);
        }
        let after = after.trim_start();
        let after = after.strip_prefix(',').unwrap_or(after).trim_start();
        Ok(Self {
            number,
            unit,
            after,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_quantity_is_refused_by_its_flaw() {
        let rate = |text| rate_bps(text).map_err(|invalid| invalid.flaw);
        let share = |text| share(text).map_err(|invalid| invalid.flaw);
        assert_eq!(rate("1.5mbit"), Ok(1_500_000));
        assert_eq!(rate("1e3 kbit"), Ok(1_000_000));
        assert_eq!(rate("1kbps"), Err(Flaw::UnknownUnit));
        assert_eq!(rate("1e13bit"), Err(Flaw::TooFast));
        assert_eq!(rate("1mbit 1mbit"), Err(Flaw::UnknownUnit));
        assert_eq!(share("50%"), Ok(0.5));
        assert_eq!(share(" 0.5 % "), Ok(0.005));
        assert_eq!(share("101%"), Err(Flaw::NotAShare));
        assert_eq!(share("-1%"), Err(Flaw::Negative));
        assert_eq!(share("0.5"), Err(Flaw::NoUnit));
        assert_eq!(share("1e999%"), Err(Flaw::NotANumber));
        assert_eq!(share("%"), Err(Flaw::NotANumber));
        assert_eq!(share(""), Err(Flaw::NotANumber));
    }
}
