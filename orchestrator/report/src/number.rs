//! Numbers as text, each sort with the digits and the unit that suit it, for tables, figures, claims and the page.

use text::significant;

/// A number for a sentence, to three digits, or to two if it is small: `0.0746`, `9.8e-4`, `infinite`.
pub fn number(number: f64) -> String {
    /// From here on, three digits would round it to 0.0100 or more.
    const SMALL: f64 = 0.009_995;
    if number.is_infinite() {
        "infinite".to_owned()
    } else if number != 0.0 && number.abs() < SMALL {
        format!("{number:.1e}")
    } else {
        significant(number, 3)
    }
}

/// Milliseconds to three digits, in the unit that suits them: `0.964 ms`, `331 ms`, `3.21 s`.
pub fn duration(ms: f64) -> String {
    // From here on, it would be rounded to 1000 ms.
    if ms.abs() >= 999.5 {
        format!("{} s", significant(ms / 1e3, 3))
    } else {
        format!("{} ms", significant(ms, 3))
    }
}

/// A number with all its digits if these are few, else to four digits: `0.0005`, `0.9167`.
pub fn brief(number: f64) -> String {
    const SHORT: usize = 8;
    let whole = number.to_string();
    if whole.len() <= SHORT {
        whole
    } else {
        significant(number, 4)
    }
}

/// A share from 0 to 1 in percent, to two digits: `1.6 %`.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(share * 100.0, 2))
}

/// A whole number up to twelve as a word: `ten`; any other in digits.
pub fn spelled(number: f64) -> String {
    const WORDS: [&str; 13] = [
        "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
        "eleven", "twelve",
    ];
    let word = WORDS
        .iter()
        .zip(0u8..)
        .find(|(_, n)| f64::from(*n) == number);
    word.map_or_else(|| number.to_string(), |(word, _)| (*word).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_a_sentence_have_three_digits_and_small_ones_two() {
        let numbers = [3033.374, 10.9, 1.004, 0.2494, 0.0746, 0.00098, -2.4e-3, 0.0];
        assert_eq!(
            numbers.map(super::number),
            [
                "3033", "10.9", "1.00", "0.249", "0.0746", "9.8e-4", "-2.4e-3", "0"
            ]
        );
        assert_eq!(super::number(f64::INFINITY), "infinite");
    }

    #[test]
    fn times_and_shares_have_units_that_suit_them() {
        assert_eq!(duration(0.9644), "0.964 ms");
        assert_eq!(duration(999.4), "999 ms");
        assert_eq!(duration(999.6), "1.00 s");
        assert_eq!(percent(0.0162), "1.6 %");
        assert_eq!(brief(3033.374), "3033.374");
        assert_eq!(brief(11.0 / 12.0), "0.9167");
    }
}
