//! Version of Compose, as far as it matters here.

use std::fmt;
use std::str::FromStr;

/// A release of Compose: its first two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// The first number.
    pub major: u32,
    /// The second one.
    pub minor: u32,
}

impl Version {
    /// The first release that reads webloop's docker-compose.yml: it supports optional
    /// dependencies, and services whose output is not shown.
    pub const OLDEST: Version = Version {
        major: 2,
        minor: 20,
    };
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// A text that is not a version.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a version of Compose; write it like 2.26.1")]
pub struct NoVersion(String);

impl FromStr for Version {
    type Err = NoVersion;

    /// Reads `2.26.1`, `v2.20.0-rc.1`, `2.26.1-4`, `5.0.0+build`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let none = || NoVersion(text.to_owned());
        let mut numbers = text
            .trim()
            .trim_start_matches('v')
            .split(|c: char| !c.is_ascii_digit());
        let mut next = || numbers.next()?.parse().ok();
        match (next(), next()) {
            (Some(major), Some(minor)) => Ok(Version { major, minor }),
            _ => Err(none()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_as_distributions_write_them_are_read() {
        let read = |text: &str| text.parse::<Version>().map(|v| v.to_string());
        for (text, version) in [
            ("2.26.1-4", "2.26"),
            ("v2.20.0-rc.1", "2.20"),
            ("2.19.1+ds1-0ubuntu1~22.04.1", "2.19"),
            ("5.0.0-desktop.1\n", "5.0"),
        ] {
            assert_eq!(read(text).as_deref(), Ok(version), "{text}");
        }
        for text in ["", "dev", "2", "v", "2.x"] {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn versions_compare_as_numbers() {
        let old = |text: &str| text.parse::<Version>().is_ok_and(|v| v < Version::OLDEST);
        assert!(old("1.29.2") && old("2.3.3") && old("2.19.9"));
        assert!(!old("2.20.0") && !old("2.100.0") && !old("5.0.0"));
    }
}
