//! Times as people write them: `6s`, `500ms`, `0.1ms`, `1e3us`, `1m 30s`.
//!
//! One grammar for profiles, systems, experiments, sweeps, settings and the command line. It is exact: 0.1 ms is
//! 100 000 ns, without a rounding on the way.

use std::ops::RangeInclusive;

use crate::quantity::{Flaw, InvalidQuantity, Term};
use crate::span::UNITS;

/// How to write a time.
const REMEDY: &str =
    "write it with its unit, like 6s, 500ms or 1m 30s (units: ns, us, ms, s, m, h)";

/// Most digits of a number that count; further ones are below any nanosecond, or beyond any range.
const DIGITS: u128 = 10_u128.pow(22);

/// Reads a time, to the nearest nanosecond, that lies in `range`.
///
/// # Errors
/// [`InvalidQuantity`] if the text is not a time, or not one in the range.
pub fn duration_ns(text: &str, range: RangeInclusive<u64>) -> Result<u64, InvalidQuantity> {
    let ns = nanoseconds(text).and_then(|(ns, _)| {
        if ns > u128::from(*range.end()) {
            Err(Flaw::TooLong(*range.end()))
        } else if ns < u128::from(*range.start()) {
            Err(Flaw::Zero)
        } else {
            Ok(ns as u64)
        }
    });
    ns.map_err(|flaw| {
        let remedy = match flaw {
            Flaw::Zero => "write a time of more than zero, such as \"10ms\"",
            Flaw::Negative => "write a time of zero or more, such as \"10ms\"",
            Flaw::TooLong(_) => "write a shorter time",
            _ => REMEDY,
        };
        InvalidQuantity::new(text, flaw, remedy)
    })
}

/// Reads a time of any length that is a whole number of nanoseconds.
///
/// # Errors
/// [`InvalidQuantity`] if the text is not such a time.
pub fn exact_ns(text: &str) -> Result<u64, InvalidQuantity> {
    let ns = nanoseconds(text).and_then(|(ns, is_whole)| match u64::try_from(ns) {
        Ok(_) if !is_whole => Err(Flaw::NotWhole),
        Ok(ns) => Ok(ns),
        Err(_) => Err(Flaw::TooLong(u64::MAX)),
    });
    ns.map_err(|flaw| InvalidQuantity::new(text, flaw, REMEDY))
}

/// The nearest number of nanoseconds, and whether the time is one exactly.
fn nanoseconds(text: &str) -> Result<(u128, bool), Flaw> {
    let (mut sum_ns, mut is_whole) = (0_u128, true);
    let mut rest = text;
    loop {
        let part = Term::first(rest)?;
        let unit_ns = unit_ns(part.unit).ok_or(Flaw::UnknownUnit)?;
        let (ns, is_exact) = product(part.number, unit_ns)?;
        sum_ns = sum_ns.saturating_add(ns);
        is_whole &= is_exact;
        rest = part.after;
        if rest.is_empty() {
            return Ok((sum_ns, is_whole));
        }
    }
}

/// Length of a unit by any of its names.
fn unit_ns(name: &str) -> Option<u64> {
    let short = match name {
        "ns" | "nsec" | "nsecs" | "nano" | "nanos" | "nanosecond" | "nanoseconds" => "ns",
        "us" | "\u{b5}s" | "\u{3bc}s" | "usec" | "usecs" | "micro" | "micros" | "microsecond"
        | "microseconds" => "µs",
        "ms" | "msec" | "msecs" | "milli" | "millis" | "millisecond" | "milliseconds" => "ms",
        "s" | "sec" | "secs" | "second" | "seconds" => "s",
        "m" | "min" | "mins" | "minute" | "minutes" => "m",
        "h" | "hr" | "hrs" | "hour" | "hours" => "h",
        _ => return None,
    };
    let found = UNITS.iter().find(|(unit, _)| *unit == short);
    found.map(|(_, unit_ns)| *unit_ns)
}

/// A decimal number of a unit of so many nanoseconds, to the nearest nanosecond, and whether it is that exactly.
fn product(number: &str, unit: u64) -> Result<(u128, bool), Flaw> {
    let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    // Not above what any text could need, so that no sum overflows.
    let exponent: i32 = exponent.parse().map_err(|_| Flaw::NotANumber)?;
    let places = i32::try_from(fraction.len()).map_err(|_| Flaw::NotANumber)?;
    let (mut value, mut shift) = (0_u128, exponent.clamp(-1_000_000, 1_000_000) - places);
    let mut is_whole = true;
    for digit in whole.bytes().chain(fraction.bytes()) {
        if !digit.is_ascii_digit() {
            return Err(Flaw::NotANumber);
        }
        let digit = u128::from(digit - b'0');
        if value < DIGITS {
            value = value * 10 + digit;
        } else {
            shift = shift.saturating_add(1);
            is_whole &= digit == 0;
        }
    }
    value *= u128::from(unit);
    if value == 0 {
        return Ok((0, is_whole));
    }
    if shift >= 0 {
        // Beyond any range, if it does not fit.
        let power = 10_u128.checked_pow(shift.unsigned_abs());
        let value = power.and_then(|power| value.checked_mul(power));
        return Ok((value.unwrap_or(u128::MAX), is_whole));
    }
    match 10_u128.checked_pow(shift.unsigned_abs()) {
        Some(power) => {
            let rounded = value / power + u128::from(value % power >= power / 2);
            Ok((rounded, is_whole && value % power == 0))
        }
        None => Ok((0, false)),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::span::{MINUTE_NS, WEEK_NS, duration_text, span_text};

    #[test]
    fn a_time_is_read_as_people_write_it_and_exactly() {
        for (text, ns) in [
            ("6s", 6_000_000_000),
            ("500ms", 500_000_000),
            ("2.5s", 2_500_000_000),
            (" 2.5 s ", 2_500_000_000),
            ("0.1ms", 100_000),
            (".5s", 500_000_000),
            ("+3ms", 3_000_000),
            ("1e3us", 1_000_000),
            ("1e+3us", 1_000_000),
            ("25e-1ms", 2_500_000),
            ("1µs", 1_000),
            ("7ns", 7),
            ("0ms", 0),
            ("1m", MINUTE_NS),
            ("1m 30s", 90_000_000_000),
            ("1m30s", 90_000_000_000),
            ("1h", 3_600_000_000_000),
            ("1 hour, 2 minutes", 3_720_000_000_000),
            ("10usec", 10_000),
        ] {
            assert_eq!(duration_ns(text, 0..=WEEK_NS), Ok(ns), "{text}");
            assert_eq!(exact_ns(text), Ok(ns), "{text}");
        }
        assert_eq!(duration_ns("0.3333333ms", 0..=WEEK_NS), Ok(333_333));
        assert_eq!(duration_ns("2.5ns", 0..=WEEK_NS), Ok(3));
    }

    #[test]
    fn what_is_no_time_is_refused_by_its_flaw() {
        for (text, flaw) in [
            ("", Flaw::NotANumber),
            ("ms", Flaw::NotANumber),
            ("soon", Flaw::NotANumber),
            ("nan", Flaw::NotANumber),
            ("1.2.3s", Flaw::NotANumber),
            ("1s soon", Flaw::NotANumber),
            ("6", Flaw::NoUnit),
            ("1s 6", Flaw::NoUnit),
            ("8d", Flaw::UnknownUnit),
            ("-1s", Flaw::Negative),
            ("0s", Flaw::Zero),
            ("200h", Flaw::TooLong(WEEK_NS)),
            ("1e999ms", Flaw::TooLong(WEEK_NS)),
            ("9999999999999999999999999999999h", Flaw::TooLong(WEEK_NS)),
        ] {
            let invalid = duration_ns(text, 1..=WEEK_NS).expect_err(text);
            assert_eq!(invalid.flaw, flaw, "{text}");
            assert!(invalid.to_string().contains(&format!("`{text}`")));
        }
        let flaw = |text| exact_ns(text).map_err(|invalid| invalid.flaw);
        assert_eq!(flaw("10000.5ns"), Err(Flaw::NotWhole));
        assert_eq!(flaw("1e-50s"), Err(Flaw::NotWhole));
        assert_eq!(flaw("99999999999999s"), Err(Flaw::TooLong(u64::MAX)));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(ns in any::<u64>()) {
            prop_assert_eq!(exact_ns(&duration_text(ns)), Ok(ns));
            prop_assert_eq!(exact_ns(&span_text(ns)), Ok(ns));
        }

        #[test]
        fn no_text_makes_it_panic(text in ".{0,40}|[0-9.eE+-]{0,60}(ms|s|h)?") {
            let _ = (exact_ns(&text), crate::share(&text), crate::rate_bps(&text));
        }
    }
}
