//! Resolves experiments into cells.
//!
//! - `experiment` is the TOML as written, [`Instead`] the caller's replacements for parts of it.
//!   `matrix` resolves both into cells, which `combination` makes; `named` looks up in a [`Library`] the
//!   profiles and systems that they name.
//! - [`sweep`] is what an experiment in virtual time may have in place of cells: `swept` keeps it in a plan, and reads
//!   it there.
//! - [`Plan`] and [`Cell`] are the result. [`Client`] closes a cell's loop; its entry has everything
//!   that is known about it. `own` has the names of programs of one's own, `client_name` those of the others.
//!   `setup` describes a cell's settings in words.
//! - [`Fault`] is what an experiment lays over a run's link and does to its ends, [`EndFault`] the latter. `faults`
//!   applies them to a plan's cells.
//! - `clause` is the language of what runs are expected to show, [`Expectation`] and [`Known`] what a plan says
//!   of it.
//! - [`Selection`] chooses cells. A [`Job`] is a share of them: those of a topology, or a [`Shard`].
//! - `limit` says how large a plan may be. `difference` says how two plans differ. `sound` refuses plans that no experiment can produce, in the
//!   words of `unsound` and `bad_fault`.
//!   `seed` derives the seeds of the links.
//! - [`file_name`] has the names of the files in a campaign's folder. [`schema()`] gives the JSON
//!   schema of experiments and plans. [`Verdict`] names how a run can end, and [`evidence`] has what that rests on. [`ProbeRow`] is the row of
//!   an echo, which back-ends and analysis share; [`series`] says when echoes are sent.
//!
//! No clock, file or thread: the cli reads and writes the files.
#![forbid(unsafe_code)]

mod allowance;
mod bad_fault;
mod cell;
mod clause;
mod client;
mod client_name;
mod combination;
mod difference;
mod echo;
mod end_fault;
pub mod evidence;
mod expect;
mod experiment;
mod fault;
mod faults;
pub mod file_name;
mod instead;
mod invalid;
mod job;
mod known;
mod library;
mod limit;
mod list;
mod matrix;
mod named;
mod own;
#[allow(clippy::module_inception)]
mod plan;
mod profile_text;
mod schema;
mod seed;
mod selection;
pub mod series;
mod setup;
mod shard;
mod sound;
mod stall;
pub mod sweep;
mod swept;
pub mod system;
mod unsound;
mod verdict;

pub use allowance::{Allowance, TAILS, Tail};
pub use bad_fault::BadFault;
pub use cell::{Cell, START_AT, rate};
pub use clause::{Clause, Figure, InvalidClause, Limit, Unit};
pub use client::{Client, ClientSpec, UnknownClient};
pub use echo::{Phase, ProbeRow};
pub use end_fault::{End, EndEffect, EndFault, EndFaultDone, STARVED_NS};
pub use expect::Expectation;
pub use experiment::RepeatCount;
pub use fault::{Fault, FaultEvent};
pub use faults::FaultSpell;
pub use instead::Instead;
pub use invalid::Reader;
pub use job::{Job, Part};
pub use known::{Day, Known, NotADay};
pub use library::Library;
pub use own::{BadOwnName, OwnName};
pub use plan::Plan;
pub use profile_text::ProfileText;
pub use schema::{Document, schema};
pub use seed::link_seed;
pub use selection::Selection;
pub use setup::{Condition, SetBy, Setup};
pub use shard::{Shard, UnknownShard};
pub use sound::is_file_name;
pub use stall::{RESPONSE_NS, stalling_seed};
pub use system::{Program, System};
pub use text::Diagnostic;
pub use unsound::{NoSystem, NotAPlan, Unsound, UnsoundCell, UnsoundName};
pub use verdict::{Disturbance, Verdict};

/// The experiments that the binary carries, by name: the paper's, parts of it, the quick ones, and sweeps.
pub const EXPERIMENTS: &[(&str, &str)] = &[
    ("quick", include_str!("../../experiments/quick.toml")),
    ("smoke", include_str!("../../experiments/smoke.toml")),
    ("paper", include_str!("../../experiments/paper.toml")),
    ("settling", include_str!("../../experiments/settling.toml")),
    ("gentle", include_str!("../../experiments/gentle.toml")),
    ("drift", include_str!("../../experiments/drift.toml")),
    ("clients", include_str!("../../experiments/clients.toml")),
    ("readings", include_str!("../../experiments/readings.toml")),
    ("systems", include_str!("../../experiments/systems.toml")),
    ("faults", include_str!("../../experiments/faults.toml")),
    (
        "end-faults",
        include_str!("../../experiments/end-faults.toml"),
    ),
    (
        "calibrate",
        include_str!("../../experiments/calibrate.toml"),
    ),
    ("margin", include_str!("../../experiments/margin.toml")),
    (
        "delay-gain",
        include_str!("../../experiments/delay-gain.toml"),
    ),
    (
        "loss-jitter",
        include_str!("../../experiments/loss-jitter.toml"),
    ),
    ("waiting", include_str!("../../experiments/waiting.toml")),
    (
        "system-margins",
        include_str!("../../experiments/system-margins.toml"),
    ),
];
