//! How a page's session ended, by the page's own report.
//!
//! The plant reads no more than this of the report. The whole is stored as it was sent, for others to read.

use serde::{Deserialize, Deserializer, Serialize};

/// Number of characters of a text that are passed on.
const EXCERPT_CHARS: usize = 200;

/// A report's data on the end of its page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct Ending {
    /// The page's word for its outcome, such as `complete` or `late`.
    #[serde(default, deserialize_with = "beginning")]
    #[serde(skip_serializing_if = "Option::is_none")]
    outcome: Option<String>,
    /// The reason, in a sentence.
    #[serde(default, deserialize_with = "beginning")]
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// The beginning of a text; `None` for other values.
fn beginning<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    let value = serde_json::Value::deserialize(deserializer)?;
    Ok(value
        .as_str()
        .map(|text| text::excerpt(text, EXCERPT_CHARS)))
}

impl Ending {
    /// Reads it from a report, which may be any JSON.
    pub(crate) fn read(report: &[u8]) -> serde_json::Result<Self> {
        let report: serde_json::Value = serde_json::from_slice(report)?;
        Ok(serde_json::from_value(report).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ending_is_read_from_whatever_is_json() {
        let ending = |text: &str| Ending::read(text.as_bytes()).expect("JSON");
        let late = ending(r#"{"outcome": "late", "reason": "by 3 ms", "counts": {}}"#);
        assert_eq!(late.outcome.as_deref(), Some("late"));
        assert_eq!(late.reason.as_deref(), Some("by 3 ms"));
        let long = ending(&format!(r#"{{"outcome": "{}"}}"#, "x".repeat(1000)));
        assert_eq!(long.outcome.map(|word| word.len()), Some(EXCERPT_CHARS));
        for other in ["1", "[]", "{}", r#"{"outcome": 1}"#] {
            assert_eq!(ending(other), Ending::default(), "{other}");
        }
        assert!(Ending::read(b"{").is_err());
    }
}
