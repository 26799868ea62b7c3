//! A link's profile as a plan has it, with what it needs to be read on another machine.

use std::collections::BTreeMap;

use link::Edition;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A profile as text: its TOML and the traces that it names.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileText {
    /// The TOML.
    pub source: String,
    /// Text of each trace file, by the name that the TOML has for it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub traces: BTreeMap<String, String>,
    /// What a trace does where the TOML does not say so. Plans of before there were two editions name none,
    /// and mean what they meant; one whose links have no trace needs none.
    #[serde(default = "Edition::first", skip_serializing_if = "Edition::is_first")]
    pub edition: Edition,
}

impl ProfileText {
    /// Reads the profile that the text describes; `origin` names it in findings.
    ///
    /// # Errors
    /// The findings that prevent the link from being played.
    pub fn profile(&self, origin: &str) -> Result<link::Profile, Vec<text::Diagnostic>> {
        let trace = |name: &str| {
            self.traces
                .get(name)
                .cloned()
                .ok_or_else(|| format!("there is no trace file `{name}`"))
        };
        let (profile, mut findings) =
            link::Profile::read_as(self.edition, &self.source, origin, &trace);
        findings.retain(|finding| finding.severity == text::Severity::Error);
        profile.ok_or(findings)
    }

    /// The same text, which names an edition only where it matters: where the profile has a trace.
    pub(crate) fn kept(mut self, profile: &link::Profile) -> ProfileText {
        if !profile.has_trace() {
            self.edition = Edition::First;
        }
        self
    }
}
