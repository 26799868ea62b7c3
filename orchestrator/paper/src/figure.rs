//! The paper's figures, recomputed. Each is made from complete runs by a file of this folder; a panel
//! without any says so.

mod arrivals;
mod interval;
mod lateness;
mod step;
mod tick;

use analysis::{Campaign, ReadError};
use report::figure::Figure;

/// Figures 2 to 9, in order.
///
/// # Errors
/// [`ReadError`] if rows that a figure needs cannot be read.
pub fn all(campaign: &Campaign) -> Result<Vec<Figure>, ReadError> {
    Ok(vec![
        arrivals::figure(campaign)?,
        lateness::slow(campaign)?,
        lateness::fast(campaign)?,
        step::near(campaign)?,
        step::far(campaign)?,
        tick::figure(campaign)?,
        interval::near(campaign)?,
        interval::far(campaign)?,
    ])
}
