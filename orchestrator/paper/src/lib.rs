//! S. L. Remy's paper "Web Standards as Standard Pieces in Robotics", recomputed from a campaign: its
//! tables, figures and claims, as [`Exhibits`] of a report.
//!
//! - [`claim`]: the claims of `claims.toml`, each checked against the runs; [`figure`]: the figures of
//!   `figures.toml`, and [`table`]: the tables, recomputed;
//! - [`printed`]: the paper's numbers; `subject`: the clients that it is about.
//!
//! Nothing here is about other experiments: what a report says about any is in [`report`].
#![forbid(unsafe_code)]

pub mod claim;
pub mod figure;
pub mod printed;
mod subject;
pub mod table;

use analysis::Campaign;
use plan::Plan;
use record::ReadError;
use report::Exhibits;

/// The name of the paper's experiment.
const EXPERIMENT: &str = "paper";

/// Whether a plan is the paper's, so that its report has the paper's exhibits without being asked.
#[must_use]
pub fn is_of(plan: &Plan) -> bool {
    plan.experiment == EXPERIMENT
}

/// The paper's tables, figures and claims, from the runs of a campaign.
///
/// # Errors
/// [`ReadError`] if rows that one of them needs cannot be read.
pub fn exhibits(campaign: &Campaign) -> Result<Exhibits, ReadError> {
    Ok(Exhibits {
        claims: claim::all(campaign)?,
        tables: table::all(campaign),
        figures: figure::all(campaign)?,
        is_own: is_of(&campaign.plan),
    })
}
