//! The plant's watchdog: how long it holds a command if no other comes, and what it does then.
//!
//! The paper's plant holds the last command, and so keeps it when its controller is gone. With a
//! watchdog its input becomes, after a time, what was declared to be safe.

use std::{fmt, str::FromStr};

use control::Signals;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::{duration_ns, span_text};

use crate::sample_time::SampleTime;

/// What the plant's input is while no command comes. Written `last`, as a time, `100ms`, after which it is 0, or
/// as a time and an action: `100ms then ramp 1s`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
pub enum Hold {
    /// The last command, for ever.
    #[default]
    Last,
    /// The last command for a time, then the safe action.
    For {
        /// How long, from the command's arrival; more than 0.
        ns: u64,
        /// What comes then.
        then: Action,
    },
}

/// What a plant does when its watchdog trips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Its input is 0.
    Zero,
    /// It declares the silence, and keeps the input.
    Hold,
    /// Its input is this, or each of two.
    Value(f64),
    /// Its input goes to 0 in a straight line.
    Ramp {
        /// For how long; more than 0.
        ns: u64,
    },
}

/// A text that is not a hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "hold `{text}` is unknown; write `last`, or a time above zero like 100ms, after which the \
     plant's input is 0, or with what comes then: `100ms then zero`, `hold`, `ramp 1s` or a number like 0.5"
)]
pub struct InvalidHold {
    /// The text.
    text: String,
}

impl Hold {
    /// Whether it is the paper's plant's.
    #[must_use]
    pub fn is_last(&self) -> bool {
        *self == Self::Last
    }

    /// The watchdog of a plant that is told none and is not the paper's: ten sample times, and a second
    /// at the least, then 0.
    #[must_use]
    pub fn safe(h: SampleTime) -> Self {
        Self::For {
            ns: h.ns().saturating_mul(10).max(1_000_000_000),
            then: Action::Zero,
        }
    }

    /// The input that the watchdog gives in place of `u`, which came `silence_ns` ago; `None` while it
    /// has not tripped.
    #[must_use]
    #[inline]
    pub fn acts(self, u: Signals, silence_ns: u64) -> Option<Signals> {
        let Self::For { ns, then } = self else {
            return None;
        };
        let over_ns = silence_ns.checked_sub(ns).filter(|over_ns| *over_ns > 0)?;
        Some(match then {
            Action::Zero => u.map(|_| 0.0),
            Action::Hold => u,
            Action::Value(value) => u.map(|_| value),
            Action::Ramp { ns } if over_ns >= ns => u.map(|_| 0.0),
            Action::Ramp { ns } => u.map(|u| u * ((ns - over_ns) as f64 / ns as f64)),
        })
    }
}

impl FromStr for Action {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        if let Some(time) = text.strip_prefix("ramp ") {
            let ns = duration_ns(time, 1..=u64::MAX).map_err(|_| ())?;
            return Ok(Self::Ramp { ns });
        }
        match text {
            "zero" => Ok(Self::Zero),
            "hold" => Ok(Self::Hold),
            number => match number.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(Self::Value(value)),
                _ => Err(()),
            },
        }
    }
}

impl FromStr for Hold {
    type Err = InvalidHold;

    fn from_str(text: &str) -> Result<Self, InvalidHold> {
        if text == "last" {
            return Ok(Self::Last);
        }
        let (time, action) = text.split_once(" then ").unwrap_or((text, "zero"));
        match (duration_ns(time, 1..=u64::MAX), action.parse()) {
            (Ok(ns), Ok(then)) => Ok(Self::For { ns, then }),
            _ => Err(InvalidHold {
                text: text.to_owned(),
            }),
        }
    }
}

impl fmt::Display for Hold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::For { ns, then } = self else {
            return f.pad("last");
        };
        let time = span_text(*ns);
        match then {
            // As it was written before there was a choice, so that the names of cells stay.
            Action::Zero => f.pad(&time),
            Action::Hold => f.pad(&format!("{time} then hold")),
            Action::Value(value) => f.pad(&format!("{time} then {value}")),
            Action::Ramp { ns } => f.pad(&format!("{time} then ramp {}", span_text(*ns))),
        }
    }
}

impl TryFrom<String> for Hold {
    type Error = InvalidHold;

    fn try_from(text: String) -> Result<Self, InvalidHold> {
        text.parse()
    }
}

impl From<Hold> for String {
    fn from(hold: Hold) -> Self {
        hold.to_string()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn it_is_read_as_it_is_written() {
        for text in [
            "last",
            "100ms",
            "2500us",
            "1s",
            "100ms then hold",
            "100ms then 0.5",
            "100ms then -3",
            "100ms then ramp 1s",
        ] {
            let hold: Hold = text.parse().expect(text);
            assert_eq!(hold.to_string(), text);
        }
        let zero: Hold = "100ms then zero".parse().expect("a hold");
        assert_eq!(zero.to_string(), "100ms");
        for text in [
            "",
            "0ms",
            "100",
            "never",
            "-1s",
            "last then zero",
            "100ms then",
            "100ms then last",
            "100ms then NaN",
            "100ms then inf",
            "100ms then ramp 0s",
            "100ms then ramp",
            "0s then zero",
        ] {
            assert!(text.parse::<Hold>().is_err(), "{text}");
        }
    }

    #[test]
    fn each_action_begins_after_the_time_and_not_before() {
        let acts = |text: &str, silence_ms: u64| {
            let hold: Hold = text.parse().expect(text);
            let acted = hold.acts(2.0.into(), silence_ms * 1_000_000);
            acted.map(|u| u.first)
        };
        assert_eq!(acts("last", u64::MAX / 1_000_000), None);
        for text in [
            "100ms",
            "100ms then hold",
            "100ms then 0.5",
            "100ms then ramp 100ms",
        ] {
            assert_eq!(acts(text, 100), None, "{text}");
        }
        assert_eq!(acts("100ms", 101), Some(0.0));
        assert_eq!(acts("100ms then hold", 101), Some(2.0));
        assert_eq!(acts("100ms then 0.5", 101), Some(0.5));
        assert_eq!(acts("100ms then ramp 100ms", 150), Some(1.0));
        assert_eq!(acts("100ms then ramp 100ms", 200), Some(0.0));
        assert_eq!(acts("100ms then ramp 100ms", 900), Some(0.0));
    }

    proptest! {
        /// So that a ramp never asks for more than was commanded, nor turns its sign.
        #[test]
        fn a_ramp_only_falls(u in -1e9..1e9_f64, first_ns in 0..3_000_000_000_u64, more_ns in 0..3_000_000_000_u64) {
            let hold: Hold = "1s then ramp 1s".parse().expect("a hold");
            let after = |silence_ns| hold.acts(u.into(), silence_ns).map_or(u, |u| u.first);
            let (before, later) = (after(first_ns), after(first_ns + more_ns));
            prop_assert!(later.abs() <= before.abs() && before.abs() <= u.abs());
            prop_assert!(later * u >= 0.0);
        }
    }
}
