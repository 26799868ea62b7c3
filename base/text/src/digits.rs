//! Numbers to so many significant digits. Which numbers want how many is for their tables and sentences to say.

/// How many decimals show a number to so many significant digits; below zero if not even its whole part needs all of
/// its digits. They are those of the rounded number: 9.996 is 10.0 to three digits, not 10.00. `None` if it is not
/// finite.
#[must_use]
pub fn decimals(number: f64, digits: u8) -> Option<i32> {
    let after = digits.saturating_sub(1);
    let scientific = format!("{number:.*e}", usize::from(after));
    let (_, exponent) = scientific.split_once('e')?;
    Some(i32::from(after) - exponent.parse::<i32>().ok()?)
}

/// A number to so many significant digits, but always with its whole integer part; from ten million on, and below a
/// millionth, with its power of ten. `-` if it is not finite.
#[must_use]
pub fn significant(number: f64, digits: u8) -> String {
    let after = digits.saturating_sub(1);
    let Some(decimals) = decimals(number, digits) else {
        return "-".to_owned();
    };
    match i32::from(after) - decimals {
        _ if number == 0.0 => "0".to_owned(),
        -6..=6 => format!("{number:.*}", usize::try_from(decimals).unwrap_or(0)),
        _ => format!("{number:.*e}", usize::from(after)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_have_their_significant_digits() {
        for (number, digits, words) in [
            (0.0, 3, "0"),
            (0.031, 2, "0.031"),
            (0.249_41, 4, "0.2494"),
            (9.996, 3, "10.0"),
            (104.188, 3, "104"),
            (3033.374, 3, "3033"),
            (3033.374, 7, "3033.374"),
            (-0.05, 2, "-0.050"),
            (2.5e8, 2, "2.5e8"),
            (f64::INFINITY, 3, "-"),
            (f64::NAN, 3, "-"),
        ] {
            assert_eq!(significant(number, digits), words);
        }
    }

    proptest! {
        #[test]
        fn what_is_printed_is_the_number_to_its_digits(number in -1e9f64..1e9, digits in 1u8..9) {
            let read: f64 = significant(number, digits).parse().expect("a number");
            let unit = number.abs() * 10f64.powi(1 - i32::from(digits));
            prop_assert!((read - number).abs() <= 0.5 * unit + 1e-12 * number.abs());
        }
    }
}
