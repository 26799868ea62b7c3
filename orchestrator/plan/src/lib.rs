//! Experiments resolved into cells.
//!
//! `experiment` is the TOML as typed, [`Instead`] what is asked for in place of it, `matrix`
//! resolves both, and `named` what they name, from a [`Library`]. [`Plan`] and [`Cell`] are the
//! result, [`Client`] says who closes a cell's loop, `setup` says how in words, [`Selection`]
//! chooses cells, [`Job`] is a share of them: a topology's, or a [`Shard`]. `difference` says in
//! what two plans differ, `seed` derives the links' seeds, [`Manifest`] is what a run says of
//! itself, [`Verdict`] names how a run can end, [`ProbeRow`] is what back-ends and analysis share of
//! the link. No clock, file or thread: the cli reads and writes the files.
#![forbid(unsafe_code)]

mod cell;
mod client;
mod difference;
mod echo;
mod experiment;
mod instead;
mod job;
mod library;
mod manifest;
mod matrix;
mod misfit;
mod named;
#[allow(clippy::module_inception)]
mod plan;
mod seed;
mod selection;
mod setup;
mod shard;
mod verdict;

pub use cell::{Cell, START_AT_NS};
pub use client::{Client, UnknownClient};
pub use echo::{Phase, ProbeRow};
pub use instead::Instead;
pub use job::{Job, Part};
pub use library::Library;
pub use manifest::{FileFact, Machine, Manifest};
pub use misfit::Misfit;
pub use plan::{Plan, ProfileText};
pub use seed::link_seed;
pub use selection::Selection;
pub use shard::{Shard, UnknownShard};
pub use verdict::Verdict;

/// The experiments that the binary carries, by name: the paper's, parts of it, and the quick
/// ones.
pub const EXPERIMENTS: &[(&str, &str)] = &[
    ("smoke", include_str!("../../experiments/smoke.toml")),
    ("paper", include_str!("../../experiments/paper.toml")),
    ("settling", include_str!("../../experiments/settling.toml")),
    ("gentle", include_str!("../../experiments/gentle.toml")),
    ("drift", include_str!("../../experiments/drift.toml")),
    ("clients", include_str!("../../experiments/clients.toml")),
    ("systems", include_str!("../../experiments/systems.toml")),
    (
        "calibrate",
        include_str!("../../experiments/calibrate.toml"),
    ),
];
