//! Numbers as written in rows.

/// A number with nine significant digits and without rounding noise: rows stay short, and a number
/// that is read back is written as the same text.
#[must_use]
pub fn brief(number: f64) -> String {
    let rounded: f64 = format!("{number:.8e}").parse().unwrap_or(number);
    // Debug, unlike Display, writes very large and very small numbers with an exponent.
    let text = format!("{rounded:?}");
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        for (number, text) in [
            (0.0, "0"),
            (3.0, "3"),
            (0.1 + 0.2, "0.3"),
            (1.0 / 3.0, "0.333333333"),
            (1.5e300, "1.5e300"),
            (-2.25e-9, "-2.25e-9"),
        ] {
            assert_eq!(brief(number), text);
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_and_written_alike(number in any::<f64>()) {
            prop_assume!(number.is_finite());
            let text = brief(number);
            let read: f64 = text.parse().expect("a number");
            prop_assert_eq!(brief(read), text);
        }
    }
}
