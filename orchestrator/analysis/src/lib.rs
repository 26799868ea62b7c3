//! Turns raw rows into metrics, verdicts and tables.
//!
//! - [`probe`], [`message`], [`arrival`], [`tick`]: the metrics of each of the four files;
//! - [`lateness`]: each arrival against the schedule; [`interval`]: histograms of the time between
//!   arrivals;
//! - [`response`]: the step response of a closed loop; [`verdict`]: whether it holds, by what is [`asked`], and for which [`reason`]; [`silence`]: whether its
//!   end was without commands, and by whose doing;
//! - [`trace`]: the series of one run that figures show;
//! - [`budget`]: the delay of each sample and message in its parts; [`blame`]: the oldest y by which the plant
//!   was steered, and what made it so old; [`recovery`]: how a loop came through a fault;
//! - [`metrics`]: all metrics of a cell's folder; [`campaign`]: all cells of a results folder;
//!   [`outline`]: the same as a row for each;
//! - [`summary`] and [`table`]: one row per cell, for programs and for people; [`repeats`]: medians
//!   over repeated cells; `condition`: the columns that say which cell a row is of; `links`: the table below
//!   them; [`expect`]: whether runs show what is expected of
//!   them; [`share`]: the share of all runs that some stand for; [`variety`]: what varied between repeats;
//! - [`mod@sweep`]: the runs of a sweep, and what is found in them;
//! - [`mod@parallel`]: work on every core;
//! - [`statistics`]: moments, quantiles and a line, each in one pass; [`binomial`]: tails of the binomial
//!   distribution; [`pairs`]: tests on paired differences; [`layout`]: columns for people.
//!
//! The crate only reads, by what [`record`] has of a folder. Raw rows are never edited, so everything derived from them can be deleted
//! and made again. Whether a link held is taken from its certificate and not judged again.
#![forbid(unsafe_code)]

pub mod arrival;
pub mod asked;
pub mod binomial;
pub mod blame;
pub mod budget;
pub mod campaign;
mod condition;
pub mod expect;
pub mod interval;
pub mod lateness;
pub mod layout;
mod links;
pub mod message;
pub mod metrics;
mod numbered;
pub mod outline;
pub mod pairs;
pub mod parallel;
pub mod probe;
pub mod reason;
pub mod recovery;
pub mod repeats;
pub mod response;
pub mod share;
pub mod silence;
pub mod statistics;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod tick;
pub mod trace;
pub mod unjudged;
pub mod variety;
pub mod verdict;

pub use campaign::{Campaign, CampaignError, Run};
pub use layout::{csv, grouped};
pub use metrics::{CellFacts, Metrics};
pub use reason::Reason;
pub use recovery::Recovery;
pub use response::{Aim, Response};
pub use summary::{LinkFacts, Summary};
pub use verdict::LoopVerdict;
