//! The paper's claims, each checked against the runs.
//!
//! Most claims are rows of a table: which client, where, at what rate, which number, and what is
//! accepted. `row` defines such a claim and the one function that judges it. The tables are in the
//! files of this folder, by figure, each with the metrics that it needs. The other claims are code.
//! Only the paper's numbers and the limits of agreement are written down in advance; what a claim
//! says about its limits is formatted from them.
//!
//! - `pace`: Figure 2; `drift`: Figures 3 and 4, with the lines of `slope`; `settling`: Figures 5 and
//!   6; `plant`: Figure 7; `interval`: Figures 8 and 9; `question`: the paper's guess, and its open
//!   questions;
//! - claims as code: `ping`: Table 2, from the series in `echo`; `together`: Table 3, with `rare` for
//!   small counts; `order`: messages out of order; `reading`: claims by other readings of the text;
//! - `evidence`: from parts to a finding; `words`: numbers and parts as text. The one rule that judges
//!   every number is [`report::claim::rule`].

mod drift;
mod echo;
mod evidence;
mod interval;
mod order;
mod pace;
mod ping;
mod plant;
mod question;
mod rare;
mod reading;
mod row;
mod settling;
mod slope;
mod together;
mod words;

use analysis::{Campaign, ReadError};
use report::claim::Finding;

/// Every claim, in the order of the paper, then the readings for which there are runs.
///
/// # Errors
/// [`ReadError`] if rows that a claim needs cannot be read.
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
