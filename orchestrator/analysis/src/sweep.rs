//! What the runs of a sweep come to: a row for each, and what is found in all of them.
//!
//! - [`Figures`] is the result of a run, [`is_stable`] decides whether its error dies out, [`Row`] is its line;
//! - [`PointRuns`]: the runs of a point taken together; [`Border`]: the longest stable delay, beside what `control`
//!   computes; [`Finding`]: axes that interact; `summary`: all of it as text for people.
//!
//! `plan` says what a sweep is, `campaign` runs it, and `report` draws it.

mod border;
mod figures;
mod finding;
mod row;
mod runs;
mod stability;
mod summary;

pub use border::{Border, Limit, borders, limit};
pub use figures::Figures;
pub use finding::{Finding, findings};
pub use row::{InvalidRow, Row, header};
pub use runs::{Measure, PointRuns};
pub use stability::{growth, is_stable};
pub use summary::summary;
