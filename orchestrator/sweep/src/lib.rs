//! How a control loop does over a grid of network conditions and settings, in virtual time.
//!
//! - what is asked: `file` and `given` (keys), `resolve` (checks), [`Sweep`], its [`Grid`] of
//!   [`Axis`]es, a [`Point`] with its loop and link (`made`: one of numbers), [`Machine`]
//! - what is run: [`Bench`] takes a point through `sim`, `trace` watches it, [`Outcome`] is what it
//!   comes to, [`is_stable`] whether it dies out, [`Row`] a line of it
//! - what is made of it: [`Cell`] (a point's runs), [`Border`] (how much delay, beside analysis),
//!   [`Finding`] (axes that act on each other), `map` (figures), `summary` (words for people)
//!
//! Threads, files and progress are the caller's: each run is a function of the sweep and its
//! number, so rows are the same in whatever order they are made.
#![forbid(unsafe_code)]

mod axis;
mod bench;
mod cell;
mod file;
mod finding;
mod given;
mod grid;
mod machine;
mod made;
mod map;
mod margin;
mod number;
mod outcome;
mod point;
mod resolve;
mod row;
mod stability;
mod summary;
#[allow(clippy::module_inception)]
mod sweep;
mod trace;

pub use axis::{Axis, UnknownAxis};
pub use bench::{Bench, Unfit};
pub use cell::{Cell, Measure};
pub use file::schema;
pub use finding::{Finding, findings};
pub use grid::{Dimension, Grid, Level};
pub use machine::{Machine, UnknownMachine};
pub use made::Made;
pub use map::maps;
pub use margin::{Border, Limit, borders, limit};
pub use outcome::Outcome;
pub use point::{Between, NoLoop, Point};
pub use row::Row;
pub use stability::{growth, is_stable};
pub use summary::summary;
pub use sweep::{Instead, Run, Sweep, checksum};

/// The sweeps that the binary carries, by name.
pub const SWEEPS: &[(&str, &str)] = &[
    ("margin", include_str!("../../sweeps/margin.toml")),
    ("delay-gain", include_str!("../../sweeps/delay-gain.toml")),
    ("loss-jitter", include_str!("../../sweeps/loss-jitter.toml")),
    ("waiting", include_str!("../../sweeps/waiting.toml")),
    ("systems", include_str!("../../sweeps/systems.toml")),
];
