//! The report on a results folder: the paper's tables, figures and claims, and a page to open.
//!
//! - [`group`]: runs that differ only in their repeat, and their medians;
//! - [`claim`]: the paper's claims, each checked against the runs; [`table`] and [`figure`]: its
//!   tables and figures, recomputed;
//! - [`junit`] and [`digest`]: for CI systems; [`deposit`]: descriptions of the folder for archives;
//!   [`outcome`]: how each cell ended, in words;
//! - [`paper`]: the paper's numbers, as printed; `subject`, `origin` and `number`: the clients that
//!   tables and figures show, where their data came from, and how their numbers are written;
//! - [`compare`]: two results folders side by side, and [`agree`]: whether one can stand for the other;
//! - [`answer`]: whether the loop survives, where, with which client;
//! - [`page`]: `report.html`, the page to open;
//! - [`report`]: the whole report as one value; [`files`]: every file that is made from it.
//!
//! Everything here is computed from an [`analysis::Campaign`] and can be deleted and made again:
//! equal folders give equal bytes. Nothing is run, and only [`files::write`] writes.
#![forbid(unsafe_code)]

pub mod agree;
pub mod answer;
pub mod brief;
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
pub mod table;
pub mod tone;

pub use files::write;
pub use report::{Exhibits, Report};
