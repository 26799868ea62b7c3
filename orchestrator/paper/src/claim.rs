//! The paper's claims, each checked against the runs.
//!
//! They are in `claims.toml`, in the paper's order: which client, where, at what rate, which figure, and what is
//! accepted. `entry` reads them, `row` judges them. To add one is to add an entry. Its words are:
//!
//! - `figure`: the numbers, which are computed by subject: `pace` (Figure 2), `drift` with the lines of `slope`
//!   (Figures 3 and 4), `settling` (5 and 6), `plant` (7, and the text), `interval` (8 and 9), `age` and `way` (the text);
//! - `remark`: what is said beyond the numbers, in the same files;
//! - `odd`: what judges the claims that are no rows: `ping`, from the series in `echo`, Table 2; `together`, with
//!   `rare` for small counts, Table 3; `order`; `constant`; `sum`.
//!
//! `metric` is what a figure is, `source` a group of runs; `evidence` makes a finding of parts; `words` has numbers
//! and parts as text. The one rule that judges every
//! number is [`report::claim::rule`].

pub(crate) mod age;
mod constant;
mod drift;
mod echo;
mod entry;
mod evidence;
mod figure;
mod interval;
mod metric;
mod odd;
mod order;
mod pace;
mod ping;
pub(crate) mod plant;
mod rare;
mod remark;
mod row;
mod settling;
mod slope;
mod source;
mod sum;
mod together;
mod way;
mod words;

use analysis::{Campaign, parallel};
use entry::Claim;
use evidence::Evidence;
use record::ReadError;
use report::claim::Finding;
use row::{Row, Weight};

/// Every claim, in the order of the paper, then the readings for which there are runs.
///
/// # Errors
/// [`ReadError`] if rows that a claim needs cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Finding>, ReadError> {
    let claims: Vec<&'static Claim> = entry::built_in().iter().collect();
    // Table 2's predict thousands of pings, which takes more time than all the rest of a report.
    let findings = parallel::each(&claims, |&claim| {
        let evidence = match claim.odd {
            Some(odd) => odd.judge(campaign)?,
            None => by_rows(campaign, claim)?,
        };
        Ok(evidence.map(|evidence| evidence.on(claim.finding())))
    });
    findings.into_iter().filter_map(Result::transpose).collect()
}

/// What is found about a claim of rows; `None` of a reading for which the plan has no cells.
fn by_rows(campaign: &Campaign, claim: &Claim) -> Result<Option<Evidence>, ReadError> {
    let is_planned =
        |row: &Row| row.weight != Weight::Beside && row.asked.group(campaign).planned > 0;
    if claim.reading_of.is_some() && !claim.rows().any(is_planned) {
        return Ok(None);
    }
    let mut evidence = Evidence::default();
    let mut judged = Vec::new();
    for row in claim.rows() {
        judged.push(row.judge(campaign, &mut evidence)?);
    }
    if let Some(remark) = claim.remark {
        remark.on(&mut evidence, &judged);
    }
    Ok(Some(evidence))
}
