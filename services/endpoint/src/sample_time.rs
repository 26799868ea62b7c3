//! The sample time h: a positive whole number of nanoseconds, written `3ms`.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// The sample time h of plant and controller.
///
/// Deadlines are start + k h in integers, so they do not drift, however long
/// the run. It is read and written with its unit: `3ms`, `100us`, `0.3s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SampleTime(u64);

/// Units, longest name first so that `ms` is not read as `s`.
const UNITS: [(&str, u64); 4] = [
    ("ns", 1),
    ("us", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
];

impl SampleTime {
    /// The shortest sample time: a tick costs about a microsecond of a core, so
    /// below ten a plant does little but chase its deadlines.
    pub const MIN_NS: u64 = 10_000;
    /// The longest: an hour. Beyond it a typing error is likelier than a plant.
    pub const MAX_NS: u64 = 3_600_000_000_000;

    /// A sample time of `ns` nanoseconds.
    ///
    /// # Errors
    /// [`InvalidSampleTime`] outside [`Self::MIN_NS`]..=[`Self::MAX_NS`].
    pub fn try_new(ns: u64) -> Result<Self, InvalidSampleTime> {
        if (Self::MIN_NS..=Self::MAX_NS).contains(&ns) {
            Ok(Self(ns))
        } else {
            Err(InvalidSampleTime::OutOfRange { ns })
        }
    }

    /// h in nanoseconds.
    #[must_use]
    pub fn ns(self) -> u64 {
        self.0
    }

    /// h in seconds, for the control law.
    #[must_use]
    pub fn seconds(self) -> f64 {
        seconds(self.0)
    }
}

/// A span of nanoseconds in seconds.
#[must_use]
pub(crate) fn seconds(ns: u64) -> f64 {
    // A quotient of two exact numbers: 3 ms is exactly the f64 nearest 0.003.
    ns as f64 / 1e9
}

/// Why a sample time was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSampleTime {
    /// Zero, too short or too long.
    #[error(
        "sample time h = {ns} ns is outside 10us to 3600s; for 333 Hz write 3ms, for 1 kHz 1ms"
    )]
    OutOfRange {
        /// What was asked.
        ns: u64,
    },
    /// Not a number and a unit.
    #[error(
        "sample time `{text}` is not a number with a unit that makes whole nanoseconds; \
         write it like 3ms, 100us or 0.3s"
    )]
    NotATime {
        /// What was asked.
        text: String,
    },
}

impl FromStr for SampleTime {
    type Err = InvalidSampleTime;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let not_a_time = || InvalidSampleTime::NotATime {
            text: text.to_owned(),
        };
        let (number, unit_ns) = UNITS
            .iter()
            .find_map(|(unit, ns)| text.strip_suffix(unit).map(|number| (number, *ns)))
            .ok_or_else(not_a_time)?;
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        let is_digits = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
        if whole.is_empty() || !is_digits(whole) || !is_digits(fraction) {
            return Err(not_a_time());
        }
        // Decimal digits by hand: 0.3 ms has to be 300000 ns, not a rounding of it.
        let mut ns = whole
            .parse::<u64>()
            .ok()
            .and_then(|whole| whole.checked_mul(unit_ns))
            .ok_or_else(not_a_time)?;
        let mut place_ns = unit_ns;
        for digit in fraction.bytes().map(|byte| u64::from(byte - b'0')) {
            if digit != 0 && !place_ns.is_multiple_of(10) {
                return Err(not_a_time());
            }
            place_ns /= 10;
            ns = ns.checked_add(digit * place_ns).ok_or_else(not_a_time)?;
        }
        Self::try_new(ns)
    }
}

impl fmt::Display for SampleTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The largest unit that divides it: 3ms, not 3000us.
        let (unit, unit_ns) = UNITS
            .iter()
            .rev()
            .find(|(_, unit_ns)| self.0.is_multiple_of(*unit_ns))
            .unwrap_or(&UNITS[0]);
        write!(f, "{}{unit}", self.0 / unit_ns)
    }
}

impl TryFrom<String> for SampleTime {
    type Error = InvalidSampleTime;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<SampleTime> for String {
    fn from(h: SampleTime) -> Self {
        h.to_string()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_time_needs_a_unit_and_whole_nanoseconds() {
        for (text, ns) in [("3ms", 3_000_000), ("0.3s", 300_000_000), ("10us", 10_000)] {
            assert_eq!(text.parse(), SampleTime::try_new(ns), "{text}");
        }
        for text in [
            "",
            "3",
            "ms",
            "-3ms",
            "3 ms",
            "NaNms",
            "1e3us",
            "10000.5ns",
            ".5s",
            "3.ms.",
            "99999999999999s",
        ] {
            assert!(
                matches!(
                    text.parse::<SampleTime>(),
                    Err(InvalidSampleTime::NotATime { .. })
                ),
                "{text}"
            );
        }
        for text in ["0ms", "9.999us", "3601s"] {
            assert!(
                matches!(
                    text.parse::<SampleTime>(),
                    Err(InvalidSampleTime::OutOfRange { .. })
                ),
                "{text}"
            );
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_the_same(ns in SampleTime::MIN_NS..=SampleTime::MAX_NS) {
            let h = SampleTime::try_new(ns).expect("the range is the valid one");
            prop_assert_eq!(h.to_string().parse(), Ok(h));
        }
    }
}
