//! Parses a row from a line as webloop writes it: by position, without quotes, without copying.
//!
//! This is a faster way to the result of the csv crate and serde, and never gives another result. A
//! line in another form (quotes, signs, a carriage return), or one that is not a row, gives `None`; whoever reads
//! the file then passes it to the csv crate and serde. So there are no error messages here.

/// The fields of a line, taken one after the other.
#[derive(Debug)]
pub struct Fields<'a> {
    /// The rest of the line; `None` after the last field.
    rest: Option<&'a [u8]>,
}

impl<'a> Fields<'a> {
    /// Those of a line without its end.
    #[must_use]
    #[inline]
    pub fn of(line: &'a [u8]) -> Self {
        Self { rest: Some(line) }
    }

    /// The next field as bytes.
    #[inline]
    fn text(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let length = rest.iter().position(|byte| *byte == b',');
        let length = length.unwrap_or(rest.len());
        self.rest = rest.get(length + 1..);
        rest.get(..length)
    }

    /// The next field as a word.
    #[inline]
    pub(crate) fn word(&mut self) -> Option<&'a str> {
        str::from_utf8(self.text()?).ok()
    }

    /// The next field as an integer in digits. At most 19 digits, which always fit into a `u64`.
    #[inline]
    pub(crate) fn count(&mut self) -> Option<u64> {
        let rest = self.rest?;
        let (mut count, mut digits): (u64, usize) = (0, 0);
        while let Some(eight) = rest.get(digits..).and_then(<[u8]>::first_chunk)
            && let Some(value) = eight_digits(*eight)
        {
            count = count.wrapping_mul(100_000_000).wrapping_add(value);
            digits += 8;
        }
        for byte in &rest[digits..] {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            count = count.wrapping_mul(10).wrapping_add(u64::from(digit));
            digits += 1;
        }
        self.pass(rest, digits)?;
        (1..=19).contains(&digits).then_some(count)
    }

    /// The next field as a float, the one nearest to the digits.
    #[inline]
    pub(crate) fn number(&mut self) -> Option<f64> {
        let rest = self.rest?;
        let (number, length) = fast_float2::parse_partial(rest).ok()?;
        self.pass(rest, length)?;
        Some(number)
    }

    /// Goes on behind a field of this length; `None` if it does not end there.
    #[inline]
    fn pass(&mut self, rest: &'a [u8], length: usize) -> Option<()> {
        self.rest = match rest.get(length) {
            None => None,
            Some(b',') => rest.get(length + 1..),
            Some(_) => return None,
        };
        Some(())
    }

    /// The next field as `read` parses it, or `Some(None)` if it is empty.
    #[inline]
    pub(crate) fn maybe<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<Option<T>> {
        let rest = self.rest?;
        if matches!(rest.first(), None | Some(b',')) {
            self.rest = rest.get(1..);
            return Some(None);
        }
        read(self).map(Some)
    }

    /// Returns the row if no field is left.
    #[must_use]
    #[inline]
    pub fn end<R>(self, row: R) -> Option<R> {
        self.rest.is_none().then_some(row)
    }
}

/// The number that eight digits are; `None` if one is none. Pairs of digits become numbers, then pairs of these,
/// then both halves, all side by side in one word.
#[inline]
fn eight_digits(bytes: [u8; 8]) -> Option<u64> {
    const HIGH: u64 = 0xf0f0_f0f0_f0f0_f0f0;
    let word = u64::from_le_bytes(bytes);
    // The upper half of a digit's byte is 3, and still is with 6 more.
    let more = word.wrapping_add(0x0606_0606_0606_0606);
    if (word & HIGH) | (more & HIGH) >> 4 != 0x3333_3333_3333_3333 {
        return None;
    }
    let pairs = ((word & 0x0f0f_0f0f_0f0f_0f0f).wrapping_mul(2561)) >> 8;
    let fours = ((pairs & 0x00ff_00ff_00ff_00ff).wrapping_mul(6_553_601)) >> 16;
    Some(((fours & 0x0000_ffff_0000_ffff).wrapping_mul(42_949_672_960_001)) >> 32)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The fields as the standard library reads them.
    fn by_std<T: std::str::FromStr>(text: &[u8]) -> Option<T> {
        str::from_utf8(text).ok()?.parse().ok()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn a_count_is_that_of_its_digits_and_nothing_else_is_one(text in "[0-9]{1,19}|[0-9:/a.+-]{0,24}") {
            let is_plain = (1..=19).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
            let count = Fields::of(text.as_bytes()).count();
            prop_assert_eq!(count, is_plain.then(|| text.parse().ok()).flatten());
            let behind = format!("{text},7");
            let mut fields = Fields::of(behind.as_bytes());
            prop_assert_eq!(fields.count(), count);
            if count.is_some() {
                prop_assert_eq!(fields.count(), Some(7));
            }
        }

        #[test]
        fn a_float_is_that_of_the_standard_library(
            bits in any::<u64>(), other in "[0-9]{1,22}[.][0-9]{0,22}(e-?[0-9]{1,3})?|[0-9.eE+-]{0,9}|inf|-inf|NaN|nan",
        ) {
            for text in [f64::from_bits(bits).to_string(), format!("{:?}", f64::from_bits(bits)), other] {
                let number = Fields::of(text.as_bytes()).number();
                let same = by_std::<f64>(text.as_bytes());
                prop_assert_eq!(number.map(f64::is_nan), same.map(f64::is_nan), "{}", text);
                if !number.is_some_and(f64::is_nan) {
                    prop_assert_eq!(number.map(f64::to_bits), same.map(f64::to_bits), "{}", text);
                }
            }
        }
    }
}
