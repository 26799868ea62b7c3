//! Turns raw rows into metrics, verdicts and tables.
//!
//! - [`rows`]: reads a file of rows in one streaming pass and counts the last lines that killed runs
//!   left torn; [`plain`]: parses a row from a line;
//! - [`probe`], [`message`], [`arrival`], [`tick`]: the metrics of each of the four files;
//! - [`lateness`]: each arrival against the schedule; [`interval`]: histograms of the time between
//!   arrivals;
//! - [`response`]: the step response of a closed loop, and the verdict on it;
//! - [`trace`]: the series of one run that figures show;
//! - [`budget`]: the delay of each sample and message in its parts; [`hold`]: where a loop was hurt, and
//!   by what; [`recovery`]: how a loop came through a fault;
//! - [`metrics`]: all metrics of a cell's folder; [`campaign`]: all cells of a results folder;
//! - `whole`: whether a folder matches its manifest; `order`: whether all of its rows are there;
//! - [`summary`] and [`table`]: one row per cell, for programs and for people; [`repeats`]: medians
//!   over repeated cells; `condition`: the columns that say which cell a row is of; `links`: the table below
//!   them; [`expect`]: whether runs show what is expected of
//!   them; [`share`]: the share of all runs that some stand for;
//! - [`mod@parallel`]: work on every core;
//! - [`statistics`]: moments, quantiles and a line, each in one pass; [`pairs`]: tests on paired
//!   differences; [`layout`]: columns for people.
//!
//! The crate only reads. Raw rows are never edited, so everything derived from them can be deleted
//! and made again. Whether a link held is taken from its certificate and not judged again.
#![forbid(unsafe_code)]

pub mod arrival;
pub mod budget;
pub mod campaign;
mod condition;
pub mod expect;
pub mod hold;
pub mod interval;
pub mod lateness;
pub mod layout;
mod links;
pub mod message;
pub mod metrics;
mod order;
pub mod pairs;
pub mod parallel;
pub mod plain;
pub mod probe;
pub mod recovery;
pub mod repeats;
pub mod response;
pub mod rows;
pub mod share;
pub mod statistics;
pub mod summary;
pub mod table;
pub mod tick;
pub mod trace;
mod whole;

pub use campaign::{Campaign, CampaignError, Run};
pub use layout::{csv, grouped};
pub use metrics::{CellFacts, Metrics};
pub use recovery::Recovery;
pub use response::{LoopVerdict, Response};
pub use rows::ReadError;
pub use summary::{LinkFacts, Summary};
pub use whole::Damage;
