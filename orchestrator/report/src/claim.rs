//! The paper's claims, each held against the runs.
//!
//! Each claim is worked out of the runs by a function of its own in a file of this folder; nothing
//! but the paper's numbers and the limits of agreement is written down beforehand.

use analysis::Campaign;
use serde::{Deserialize, Serialize};

use crate::group::Estimate;

/// What came of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// What the runs show is what the paper says, within the limits that are stated.
    Agrees,
    /// It is not.
    Differs,
    /// The runs cannot tell, and the reason says why.
    NotComparable,
    /// The runs that it needs have not been made, or not completely.
    NotRun,
}

/// A claim beside what the runs say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// A name for programs that stays the same: `fig-6b-settling-vpn`.
    pub id: &'static str,
    /// Where the paper says it: `Fig 6b`.
    pub place: &'static str,
    /// What it says, in a sentence of ours.
    pub claim: &'static str,
    /// What counts as agreement, in words: `settling 3 to 5 times that on arima`.
    pub check: &'static str,
    /// The worst of its parts'.
    pub verdict: Verdict,
    /// Why, in a sentence with numbers in it; of a difference, what explains it.
    pub reason: String,
    /// What was measured.
    pub parts: Vec<Part>,
    /// The cells that it came from, by id.
    pub runs: Vec<String>,
}

/// One number of a claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// What was measured, where: `settling, python, diego-vpn, 333 Hz`.
    pub of: String,
    /// The unit, empty for a share or a ratio.
    pub unit: &'static str,
    /// The paper's number, where it has one.
    pub paper: Option<f64>,
    /// Ours; `None` where it was not run.
    pub ours: Option<Estimate>,
    /// From where to where ours agrees; an end that is open is infinite.
    #[serde(serialize_with = "open_ends")]
    pub accepted: Option<(f64, f64)>,
    /// What came of it.
    pub verdict: Verdict,
}

impl Part {
    /// A number that agrees where it lies within `accepted`.
    #[must_use]
    pub fn judged(
        of: impl Into<String>,
        unit: &'static str,
        paper: Option<f64>,
        ours: Option<Estimate>,
        accepted: (f64, f64),
    ) -> Part {
        let verdict = match ours {
            None => Verdict::NotRun,
            Some(ours) if (accepted.0..=accepted.1).contains(&ours.value) => Verdict::Agrees,
            Some(_) => Verdict::Differs,
        };
        Part {
            of: of.into(),
            unit,
            paper,
            ours,
            accepted: Some(accepted),
            verdict,
        }
    }
}

/// Every claim, in the order of the paper.
///
/// # Errors
/// [`analysis::ReadError`] where rows that a claim needs cannot be read.
pub fn all(_campaign: &Campaign) -> Result<Vec<Finding>, analysis::ReadError> {
    Ok(Vec::new())
}

/// JSON has no infinity: an open end is null.
fn open_ends<S: serde::Serializer>(
    accepted: &Option<(f64, f64)>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let end = |x: f64| x.is_finite().then_some(x);
    accepted
        .map(|(low, high)| (end(low), end(high)))
        .serialize(serializer)
}
