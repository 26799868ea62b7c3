//! Quantities as written in a profile: a number and tc's unit.

use thiserror::Error;

/// Longest time that a profile may give: a day. Anything longer is a mistake, and sums of a few such
/// times are far below the limit of a `u64` of nanoseconds.
const LONGEST_S: f64 = 86_400.0;
/// Greatest rate that a profile may give.
const FASTEST_BPS: f64 = 1e12;

/// Why a text is not the expected quantity.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // The messages are the documentation.
pub enum InvalidQuantity {
    #[error("`{0}` is not a number with a unit")]
    NotANumber(String),
    #[error("`{0}` has no unit")]
    NoUnit(String),
    #[error("`{0}` has an unknown unit")]
    UnknownUnit(String),
    #[error("`{0}` is negative")]
    Negative(String),
    #[error("`{0}` is not finite")]
    NotFinite(String),
    #[error("`{0}` is longer than a day")]
    TooLong(String),
    #[error("`{0}` is more than 1 Tbit/s")]
    TooFast(String),
    #[error("`{0}` lies outside 0 % to 100 %")]
    NotAShare(String),
}

/// A time such as `"10ms"`, in nanoseconds.
///
/// # Errors
/// [`InvalidQuantity`] if it is not a time, is negative, or is longer than a day.
pub fn duration_ns(text: &str) -> Result<f64, InvalidQuantity> {
    let (number, unit) = split(text)?;
    let scale = match unit {
        "ns" | "nsec" => 1e-9,
        "us" | "usec" => 1e-6,
        "ms" | "msec" => 1e-3,
        "s" | "sec" => 1.0,
        _ => return Err(InvalidQuantity::UnknownUnit(text.to_owned())),
    };
    if number * scale > LONGEST_S {
        return Err(InvalidQuantity::TooLong(text.to_owned()));
    }
    // One multiplication by a whole number: "0.1ms" is 100 000 ns exactly.
    Ok((number * libm::round(scale * 1e9)).round())
}

/// A rate such as `"1mbit"`, in bit/s.
///
/// # Errors
/// [`InvalidQuantity`] if it is not a rate, is negative, or is more than 1 Tbit/s.
pub fn rate_bps(text: &str) -> Result<u64, InvalidQuantity> {
    let (number, unit) = split(text)?;
    let scale = match unit {
        "bit" => 1.0,
        "kbit" => 1e3,
        "mbit" => 1e6,
        "gbit" => 1e9,
        _ => return Err(InvalidQuantity::UnknownUnit(text.to_owned())),
    };
    if number * scale > FASTEST_BPS {
        return Err(InvalidQuantity::TooFast(text.to_owned()));
    }
    Ok(libm::round(number * scale) as u64)
}

/// A share such as `"0.8%"`, as a fraction.
///
/// # Errors
/// [`InvalidQuantity`] if it is not a share of 0 to 100 %.
pub fn share(text: &str) -> Result<f64, InvalidQuantity> {
    let (number, unit) = split(text)?;
    match unit {
        "%" if number <= 100.0 => Ok(number / 100.0),
        "%" => Err(InvalidQuantity::NotAShare(text.to_owned())),
        _ => Err(InvalidQuantity::UnknownUnit(text.to_owned())),
    }
}

/// A finite number, zero or more, and the unit after it.
fn split(text: &str) -> Result<(f64, &str), InvalidQuantity> {
    let trimmed = text.trim();
    let unit_at = trimmed
        .char_indices()
        .find(|&(at, c)| {
            // The e of "1e3ms" belongs to the number; an e in a unit does not.
            let exponent = (c == 'e' || c == 'E')
                && trimmed[at + 1..].starts_with(|c: char| c.is_ascii_digit() || c == '-');
            !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+') || exponent)
        })
        .map_or(trimmed.len(), |(at, _)| at);
    let (number, unit) = trimmed.split_at(unit_at);
    let number: f64 = match number.parse() {
        Ok(number) => number,
        Err(_) if matches!(trimmed.parse::<f64>(), Ok(x) if !x.is_finite()) => f64::NAN,
        Err(_) => return Err(InvalidQuantity::NotANumber(text.to_owned())),
    };
    if !number.is_finite() {
        return Err(InvalidQuantity::NotFinite(text.to_owned()));
    }
    if number < 0.0 {
        return Err(InvalidQuantity::Negative(text.to_owned()));
    }
    match unit.trim() {
        "" => Err(InvalidQuantity::NoUnit(text.to_owned())),
        unit => Ok((number, unit)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_in_tc_units() {
        for (text, want_ns) in [
            ("10ms", 1e7),
            ("0.1ms", 1e5),
            (" 2.5 s ", 2.5e9),
            ("1e3us", 1e6),
            ("7ns", 7.0),
            ("0ms", 0.0),
        ] {
            assert_eq!(duration_ns(text), Ok(want_ns), "{text}");
        }
    }

    #[test]
    fn what_is_no_quantity_is_refused_by_name() {
        use InvalidQuantity::*;
        let owned = str::to_owned;
        assert_eq!(duration_ns("10"), Err(NoUnit(owned("10"))));
        assert_eq!(duration_ns("-1ms"), Err(Negative(owned("-1ms"))));
        assert_eq!(duration_ns("nan"), Err(NotFinite(owned("nan"))));
        assert_eq!(duration_ns("1e999ms"), Err(NotFinite(owned("1e999ms"))));
        assert_eq!(duration_ns("25e3s"), Ok(25e12));
        assert_eq!(duration_ns("1e6s"), Err(TooLong(owned("1e6s"))));
        assert_eq!(duration_ns("ms"), Err(NotANumber(owned("ms"))));
        assert_eq!(duration_ns("1m"), Err(UnknownUnit(owned("1m"))));
        assert_eq!(duration_ns("1µs"), Err(UnknownUnit(owned("1µs"))));
        assert_eq!(rate_bps("1kbps"), Err(UnknownUnit(owned("1kbps"))));
        assert_eq!(rate_bps("1.5mbit"), Ok(1_500_000));
        assert_eq!(share("101%"), Err(NotAShare(owned("101%"))));
        assert_eq!(share("0.5"), Err(NoUnit(owned("0.5"))));
        assert_eq!(share("50%"), Ok(0.5));
    }
}
