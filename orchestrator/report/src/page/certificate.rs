//! A link's certificate as its manifest has it: what was measured, beside what the link had.

use plan::Manifest;
use serde::Deserialize;
use serde_json::Value;

/// What of a certificate is shown. A field that another version did not write is empty.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Certificate {
    /// `"holds"`, or an object with the reasons.
    pub(super) verdict: Value,
    #[serde(default)]
    pub(super) sent: u64,
    #[serde(default)]
    pub(super) answered: u64,
    pub(super) measured: Option<Rtt>,
    pub(super) predicted: Option<Rtt>,
    pub(super) residuals: Option<Residuals>,
}

/// Round trips.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) struct Rtt {
    pub(super) min_ms: f64,
    pub(super) avg_ms: f64,
    pub(super) max_ms: f64,
    pub(super) sd_ms: f64,
    pub(super) loss: f64,
}

/// How far the echoes lay from what the link had for them.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) struct Residuals {
    pub(super) rtt: Option<Residual>,
}

/// Absolute values of the distance, and its mean with its sign.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) struct Residual {
    pub(super) bias_ms: f64,
    pub(super) median_ms: f64,
    pub(super) p99_ms: f64,
    pub(super) max_ms: f64,
}

impl Certificate {
    /// The manifest's; `None` where there is none, or one that this version cannot read.
    pub(super) fn of(manifest: &Manifest) -> Option<Certificate> {
        serde_json::from_value(manifest.certificate.clone()?).ok()
    }

    /// Whether the link was the one asked for.
    pub(super) fn holds(&self) -> bool {
        self.verdict == "holds"
    }

    /// The residuals over the round trip.
    pub(super) fn residual(&self) -> Option<Residual> {
        self.residuals?.rtt
    }
}
