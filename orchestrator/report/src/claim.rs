//! A claim, with the verdict of the runs on it: what the paper says, checked against numbers.
//!
//! - `rule`: the one rule that judges every number; `format`: the files.
//!
//! The claims themselves are those of a publication, and so are in a crate of their own.

mod format;
pub mod rule;

use serde::{Deserialize, Serialize};

use crate::group::Estimate;

pub use format::{to_csv, to_json};
pub use rule::Limits;

/// The verdict on a claim, from the best to the worst: a part that differs outweighs one that cannot
/// be told, and missing runs outweigh both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The runs show what the paper says, within the stated limits.
    Agrees,
    /// The runs are on both sides of a limit, or too few for an interval, or the paper has no number
    /// to compare them with.
    CannotBeTold,
    /// The runs show something else.
    Differs,
    /// Runs that it needs are missing or not complete.
    NotRun,
}

/// A claim, with what the runs say about it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// A stable name for programs: `fig-6b-settling-vpn`.
    pub id: &'static str,
    /// Where the paper says it: `Fig 6b`.
    pub place: &'static str,
    /// What it says, in our words.
    pub claim: &'static str,
    /// What counts as agreement, in words: `settling 3 to 5 times that on arima`.
    pub check: String,
    /// The claim of which this is a reading: with settings, or an evaluation of the same rows, that
    /// the paper's text allows but does not state. A reading is not counted as a claim.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading_of: Option<&'static str>,
    /// The worst verdict of the parts that decide, which come first. Parts that are only shown, such
    /// as those of a browser that the paper does not name, have verdicts of their own.
    pub verdict: Verdict,
    /// Why, in sentences with numbers; for a difference, also what explains it.
    pub reason: String,
    /// What was measured.
    pub parts: Vec<Part>,
    /// Ids of the cells that it is based on.
    pub runs: Vec<String>,
}

/// One number of a claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// What was measured, and where: `settling, python, diego-vpn, 333 Hz`.
    pub of: String,
    /// What was measured, without where: `settling`.
    #[serde(skip)]
    pub quantity: String,
    /// The unit, empty for a share or a ratio.
    pub unit: &'static str,
    /// The paper's number, if it has one.
    pub paper: Option<f64>,
    /// Our number; `None` if it was not run.
    pub ours: Option<Estimate>,
    /// The range in which our number agrees; an open end is infinite.
    #[serde(serialize_with = "open_ends")]
    pub accepted: Option<(f64, f64)>,
    /// The verdict on the number.
    pub verdict: Verdict,
}

impl Part {
    /// A number, judged by the rule in `rule`.
    #[must_use]
    pub fn judged(
        of: impl Into<String>,
        unit: &'static str,
        paper: Option<f64>,
        ours: Option<Estimate>,
        limits: impl Into<Limits>,
    ) -> Part {
        let limits = limits.into();
        let of = of.into();
        Part {
            quantity: of.clone(),
            of,
            unit,
            paper,
            ours,
            accepted: Some(limits.shown()),
            verdict: rule::judge(ours, &limits),
        }
    }

    /// The same part with its place: `python, diego-vpn, 333 Hz`.
    #[must_use]
    pub fn at(self, place: &str) -> Part {
        Part {
            of: format!("{}, {place}", self.quantity),
            ..self
        }
    }
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
