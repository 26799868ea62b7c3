//! The paper's claims, each held against the runs.
//!
//! Most claims are rows of a table: whom to ask, where, at what rate, for which number, and what is
//! accepted. `row` is what such a claim consists of, and the one function that judges it; the tables
//! stand by figure in the files of this folder, each with the numbers that it asks for. The odd claims
//! are code. Nothing but the paper's numbers and the limits of agreement is written down beforehand, and
//! what a claim says of its limits is formatted from them.
//!
//! - `pace`: Figure 2; `drift`: Figures 3 and 4, by the lines in `slope`; `settling`: Figures 5 and 6;
//!   `plant`: Figure 7; `interval`: Figures 8 and 9; `question`: the guess, and what is left open;
//! - the odd ones: `ping`: Table 2, from the series in `echo`; `together`: Table 3, with `rare` for counts
//!   of a few; `order`: what was overtaken; `reading`: claims read as the text also allows;
//! - `rule`: the one rule by which every number is judged; `evidence`: from parts to a finding; `estimate`:
//!   numbers with their intervals; `words`: both in a sentence; `format`: the files.

mod drift;
mod echo;
mod estimate;
mod evidence;
mod format;
mod interval;
mod order;
mod pace;
mod ping;
mod plant;
mod question;
mod rare;
mod reading;
mod row;
mod rule;
mod settling;
mod slope;
mod together;
mod words;

use analysis::{Campaign, ReadError};
use serde::{Deserialize, Serialize};

use crate::group::Estimate;

pub use format::{to_csv, to_json};
pub use rule::Limits;

/// What came of a claim, from the best to the worst: a part that differs weighs more than one that
/// cannot be compared, and without the runs there is nothing to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// What the runs show is what the paper says, within the limits that are stated.
    Agrees,
    /// The runs are on both sides of a limit, or too few for an interval, or the paper has no number to
    /// hold them against.
    CannotBeTold,
    /// What they show is something else.
    Differs,
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
    pub check: String,
    /// The claim that this is a reading of: settings, or a look at the same rows, that the paper's text allows
    /// and does not state. A reading is no claim and is not counted as one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading_of: Option<&'static str>,
    /// The worst of the parts that decide. Those come first; what is only shown beside them, such as
    /// a browser that the paper does not name, has a verdict of its own.
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
    /// What was measured, without where: `settling`.
    #[serde(skip)]
    pub quantity: String,
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
    /// A number that is judged by the one rule: see `rule`.
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

    /// The same of this place: `python, diego-vpn, 333 Hz`.
    #[must_use]
    pub fn at(self, place: &str) -> Part {
        Part {
            of: format!("{}, {place}", self.quantity),
            ..self
        }
    }
}

/// Every claim, in the order of the paper, and after them the readings that there are runs for.
///
/// # Errors
/// [`ReadError`] where rows that a claim needs cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let mut findings = ping::table_2(campaign)?;
    findings.push(ping::couva(campaign)?);
    findings.extend(together::table_3(campaign)?);
    findings.push(order::out_of_order(campaign));
    let table = [
        pace::figure_2(),
        drift::figure_3(),
        drift::figure_4(),
        settling::figure_5(),
        settling::figure_6(),
        plant::figure_7(),
        interval::figure_8(),
        interval::figure_9(),
        question::guess(),
    ];
    for claim in table.into_iter().flatten() {
        findings.push(row::judge(campaign, claim)?);
    }
    findings.extend(question::future(campaign));
    findings.extend(reading::all(campaign)?);
    Ok(findings)
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
