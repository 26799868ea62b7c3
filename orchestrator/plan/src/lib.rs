//! Experiments resolved into cells.
//!
//! `experiment` is the TOML as typed, [`Instead`] what is asked for in place of it, `matrix`
//! resolves both, and `named` what they name, from a [`Library`]. [`Plan`] and [`Cell`] are the
//! result, [`Client`] says who closes a cell's loop and has all that is known of it, `setup` says how in words, [`Selection`]
//! chooses cells, [`Job`] is a share of them: a topology's, or a [`Shard`]. `difference` says in
//! what two plans differ, [`file_name`] has the names of a folder's files, `sound` refuses plans
//! that no experiment comes to, `seed` derives the links' seeds, [`schema`] says in JSON what an
//! experiment and a plan may hold, [`Verdict`] names how a run can end, [`ProbeRow`] is what back-ends
//! and analysis share of the link, [`series`] when its echoes are sent. No clock, file or thread: the
//! cli reads and writes the files.
#![forbid(unsafe_code)]

mod allowance;
mod cell;
mod client;
mod difference;
mod echo;
mod experiment;
pub mod file_name;
mod instead;
mod invalid;
mod job;
mod library;
mod matrix;
mod named;
#[allow(clippy::module_inception)]
mod plan;
mod schema;
mod seed;
mod selection;
pub mod series;
mod setup;
mod shard;
mod sound;
mod stall;
mod verdict;

pub use allowance::Allowance;
pub use cell::{Cell, START_AT_NS};
pub use client::{Client, ClientSpec, UnknownClient};
pub use echo::{Phase, ProbeRow};
pub use instead::Instead;
pub use invalid::{InvalidFile, Reader};
pub use job::{Job, Part};
pub use library::Library;
pub use plan::{Plan, ProfileText};
pub use schema::{Document, schema};
pub use seed::link_seed;
pub use selection::Selection;
pub use shard::{Shard, UnknownShard};
pub use sound::is_file_name;
pub use stall::{RESPONSE_NS, stalling_seed};
pub use verdict::{Disturbance, Verdict};

/// The experiments that the binary carries, by name: the paper's, parts of it, and the quick
/// ones.
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
    (
        "calibrate",
        include_str!("../../experiments/calibrate.toml"),
    ),
];
