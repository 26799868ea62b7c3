//! The sample time h: a positive whole number of nanoseconds, written `3ms`.

use std::{fmt, str::FromStr};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::{exact_ns, span_text};

/// The sample time h of plant and controller.
///
/// Deadlines are start + k h in integers, so they do not drift, however long
/// the run. It is read and written with its unit: `3ms`, `100us`, `0.3s`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
pub struct SampleTime(u64);

impl SampleTime {
    /// The shortest sample time, 10 us: a tick costs about a microsecond of a core, so with a shorter
    /// one a plant does little but try to meet its deadlines.
    pub const MIN_NS: u64 = 10_000;
    /// The longest sample time: an hour. Anything longer is more likely a typing error than a plant.
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
        control::seconds(self.0)
    }

    /// The number k of the first deadline after `now_ns`, of those at `start_ns` + k h.
    #[must_use]
    pub fn next_k(self, start_ns: u64, now_ns: u64) -> u64 {
        let passed_ns = now_ns.checked_sub(start_ns);
        passed_ns.map_or(0, |passed_ns| passed_ns / self.0 + 1)
    }
}

/// Why a sample time was rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSampleTime {
    /// It is zero, too short or too long.
    #[error(
        "sample time h = {ns} ns is outside 10us to 3600s; for 333 Hz write 3ms, for 1 kHz 1ms"
    )]
    OutOfRange {
        /// The given sample time, ns.
        ns: u64,
    },
    /// It is a rate.
    #[error("sample time `{text}` is a rate; write {h}, the time from one sample to the next")]
    Rate {
        /// The given text.
        text: String,
        /// Its sample time.
        h: SampleTime,
    },
    /// It is not a number with a unit.
    #[error(
        "sample time `{text}` is not a number with a unit that makes whole nanoseconds; \
         write it like 3ms, 100us or 0.3s"
    )]
    NotATime {
        /// The given text.
        text: String,
    },
}

impl FromStr for SampleTime {
    type Err = InvalidSampleTime;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text_of = || text.to_owned();
        let ns = exact_ns(text).map_err(|_| match of_rate(text) {
            Some(h) => InvalidSampleTime::Rate { text: text_of(), h },
            None => InvalidSampleTime::NotATime { text: text_of() },
        })?;
        Self::try_new(ns)
    }
}

/// The sample time of a rate such as `100 Hz`, to the microsecond; `None` if the text is none.
fn of_rate(text: &str) -> Option<SampleTime> {
    let number = text.trim().strip_suffix("Hz")?;
    let (number, hz) = match number.strip_suffix('k') {
        Some(number) => (number, 1e3),
        None => (number, 1.0),
    };
    let rate_hz = number.trim().parse::<f64>().ok()? * hz;
    // A number too large, or none, becomes one that no sample time has.
    let h_us = (1e6 / rate_hz).round() as u64;
    SampleTime::try_new(h_us.saturating_mul(1_000)).ok()
}

impl fmt::Display for SampleTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&span_text(self.0))
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
        for (text, ns) in [
            ("3ms", 3_000_000),
            ("0.3s", 300_000_000),
            ("10us", 10_000),
            ("3 ms", 3_000_000),
            ("1e3us", 1_000_000),
            (".5s", 500_000_000),
        ] {
            assert_eq!(text.parse(), SampleTime::try_new(ns), "{text}");
        }
        for text in [
            "",
            "3",
            "ms",
            "-3ms",
            "NaNms",
            "10000.5ns",
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
