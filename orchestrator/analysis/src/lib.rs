//! Raw rows into metrics, verdicts, tables.
//!
//! - [`rows`]: a file of rows in one streaming pass; what a killed run left torn is counted;
//!   [`plain`]: a row from a line;
//! - [`probe`], [`message`], [`arrival`], [`tick`]: what each of the four files says;
//! - [`lateness`] and [`interval`]: the arrivals one by one against the schedule, and the histograms
//!   of the time between them;
//! - [`response`]: the step response of a closed loop, and the verdict on it;
//! - [`trace`]: what a figure shows of one run, row by row;
//! - [`metrics`]: all of a cell's folder; [`campaign`]: all cells of a results folder;
//! - `whole`: whether a folder is what its manifest says; `order`: whether its rows are all there;
//! - [`summary`] and [`table`]: a cell in a row, for programs and for people; [`repeats`]: the
//!   medians of cells that were repeated;
//! - [`statistics`]: moments, quantiles and a line, each in one pass; [`pairs`]: tests on paired
//!   differences; [`layout`]: columns for people.
//!
//! The crate only reads: raw rows are never edited, so that everything here can be deleted and
//! made again. Whether a link held is in its certificate and not judged again.
#![forbid(unsafe_code)]

pub mod arrival;
pub mod campaign;
pub mod interval;
pub mod lateness;
pub mod layout;
mod links;
pub mod message;
pub mod metrics;
mod order;
pub mod pairs;
mod parallel;
pub mod plain;
pub mod probe;
pub mod repeats;
pub mod response;
pub mod rows;
pub mod statistics;
pub mod summary;
pub mod table;
pub mod tick;
pub mod trace;
mod whole;

pub use campaign::{Campaign, CampaignError, Run};
pub use layout::{csv, grouped};
pub use metrics::{CellFacts, Metrics};
pub use response::{LoopVerdict, Response};
pub use rows::ReadError;
pub use summary::{LinkFacts, Summary};
pub use whole::Damage;
