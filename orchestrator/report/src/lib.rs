//! The report on a results folder, whatever the experiment: figures, tables, and a page to open.
//!
//! - [`answer`]: whether the loop survives, where, with which client; [`brief`]: the questions, answered;
//! - [`group`]: runs that differ only in their repeat, and their medians; [`loops`]: the closed loops;
//!   [`delays`]: how long messages and samples took, and the run nearest to failing;
//! - [`table`] and [`figure`]: what is shown, each made by a file of its folder; [`tone`] and [`number`]: their
//!   colours and their numbers as text; [`origin`]: where their data came from;
//! - [`claim`]: the claims of a publication with their verdicts, which a crate of its own makes and hands over
//!   as [`Exhibits`];
//! - [`junit`] and [`digest`]: for CI systems; [`deposit`]: descriptions of the folder for archives;
//!   [`outcome`]: how each cell ended, in words;
//! - [`compare`]: two results folders side by side, and [`agree`]: whether one can stand for the other;
//! - [`page`]: `report.html`, the page to open;
//! - [`sweep`]: the report on a sweep: its maps, its findings, its page;
//! - [`report`]: the whole report as one value; [`files`]: every file that is made from it.
//!
//! Everything here is computed from an [`analysis::Campaign`] and can be deleted and made again:
//! equal folders give equal bytes. Nothing is run, and only [`files::write`] writes.
#![forbid(unsafe_code)]

pub mod agree;
pub mod answer;
pub mod brief;
pub mod called;
pub mod claim;
pub mod compare;
pub mod delays;
pub mod deposit;
pub mod digest;
pub mod figure;
pub mod files;
pub mod group;
pub mod junit;
pub mod loops;
pub mod number;
pub mod origin;
pub mod outcome;
pub mod page;
#[allow(clippy::module_inception)]
pub mod report;
#[cfg(test)]
mod sample;
pub mod sweep;
pub mod table;
pub mod tone;

pub use files::write;
pub use report::{Exhibits, Report};
