//! A results folder as the paper tells it: tables, figures, claims, and a page to open.
//!
//! - [`group`]: runs that differ only in their repeat, and what they agree on;
//! - [`claim`]: the paper's claims, each held against the runs; [`table`] and [`figure`]: its tables
//!   and figures, recomputed;
//! - [`junit`] and [`digest`]: what CI systems show of it; [`deposit`]: what archives read of the
//!   folder; [`outcome`]: how each cell ended, in the words that both use;
//! - [`paper`]: the paper's numbers, as printed; `subject`, `origin` and `number`: whom tables and
//!   figures show, where they came from, and how their numbers are written;
//! - [`compare`]: two results folders side by side, and [`agree`]: whether one can stand for the other;
//! - [`answer`]: whether the loop survives, where, with which client;
//! - [`page`]: `report.html`, the page to open;
//! - [`report`]: all of it as one value; [`files`]: every file that is made of it.
//!
//! Everything here is worked out of a [`analysis::Campaign`] and can be deleted and made again:
//! equal folders give equal bytes. Nothing is run, and only [`files::write`] writes.
#![forbid(unsafe_code)]

pub mod agree;
pub mod answer;
pub mod claim;
pub mod compare;
pub mod deposit;
pub mod digest;
pub mod figure;
pub mod files;
pub mod group;
pub mod junit;
mod number;
mod origin;
pub mod outcome;
pub mod page;
pub mod paper;
#[allow(clippy::module_inception)]
pub mod report;
#[cfg(test)]
mod sample;
mod subject;
pub mod table;

pub use files::write;
pub use report::Report;
