//! Durations as people write them: `6s`, `500ms`, `1m 30s`.
//!
//! For the duration of a run or of a part of it, in experiments, sweeps and settings. [`crate::span`]
//! reads sample times, which must be exact; the times of a profile are in tc's syntax.

use jiff::SignedDuration;

/// How to write a duration.
pub const DURATION_REMEDY: &str = "write it with its unit, like 6s, 500ms or 1m 30s";

/// The longest duration: a week. Anything longer is more likely a typing error than a run.
pub const DURATION_MAX_NS: u64 = 7 * 24 * 3_600_000_000_000;

/// Reads a duration in nanoseconds.
///
/// # Errors
/// A sentence that says what is wrong, if the text is not a duration, or not one above 0 and up to a
/// week; [`DURATION_REMEDY`] belongs to it.
pub fn duration_ns(text: &str) -> Result<u64, String> {
    match floor_ns(text) {
        Ok(0) => Err(out_of_range(text)),
        other => other,
    }
}

/// Reads a duration in nanoseconds, which may be 0.
///
/// # Errors
/// The same as [`duration_ns`], except for 0.
pub(crate) fn floor_ns(text: &str) -> Result<u64, String> {
    let duration: SignedDuration = text
        .parse()
        .map_err(|_| format!("`{text}` is not a duration"))?;
    u64::try_from(duration.as_nanos())
        .ok()
        .filter(|ns| *ns <= DURATION_MAX_NS)
        .ok_or_else(|| out_of_range(text))
}

fn out_of_range(text: &str) -> String {
    format!("`{text}` is not between 0 and a week")
}

/// A duration as people write it: `10ms`, `1s 500ms`.
#[must_use]
pub fn duration_text(ns: u64) -> String {
    let ns = i64::try_from(ns).unwrap_or(i64::MAX);
    format!("{:#}", SignedDuration::from_nanos(ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_read_as_people_write_it() {
        for (text, ns) in [
            ("6s", 6_000_000_000),
            ("500ms", 500_000_000),
            ("2.5s", 2_500_000_000),
            ("1m", 60_000_000_000),
            ("1m 30s", 90_000_000_000),
            ("1h", 3_600_000_000_000),
        ] {
            assert_eq!(duration_ns(text), Ok(ns), "{text}");
        }
        for text in ["", "6", "0s", "-1s", "8d", "soon", "9999999999999h"] {
            let said = duration_ns(text).expect_err(text);
            assert!(said.contains(&format!("`{text}`")), "{said}");
        }
    }
}
