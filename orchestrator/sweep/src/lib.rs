//! How a control loop behaves over a grid of network conditions and settings, in virtual time.
//!
//! - input: `file` and `given` (keys), `resolve` (checks), [`Sweep`], its [`Grid`] of [`Axis`]es, a
//!   [`Point`] with its loop and link (`made`: a link from numbers), [`Machine`]
//! - runs: [`Bench`] runs a point in `sim`, `trace` records it, [`Figures`] is the result,
//!   [`is_stable`] decides whether the error dies out, [`Row`] is its line
//! - results: [`Cell`] (a point's runs), [`Border`] (the longest stable delay, beside its analysis),
//!   [`Finding`] (axes that interact), `map` (figures), `summary` (text for people)
//!
//! Threads, files and progress are the caller's task: each run is a function of the sweep and its
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
pub use made::{Made, Unplayable};
pub use map::maps;
pub use margin::{Border, Limit, borders, limit};
pub use outcome::Figures;
pub use point::{Between, NoLoop, Point};
pub use row::{InvalidRow, Row};
pub use stability::{growth, is_stable};
pub use summary::summary;
pub use sweep::{Instead, Run, Sweep, checksum};

/// The built-in sweeps, by name.
pub const SWEEPS: &[(&str, &str)] = &[
    ("margin", include_str!("../../sweeps/margin.toml")),
    ("delay-gain", include_str!("../../sweeps/delay-gain.toml")),
    ("loss-jitter", include_str!("../../sweeps/loss-jitter.toml")),
    ("waiting", include_str!("../../sweeps/waiting.toml")),
    ("systems", include_str!("../../sweeps/systems.toml")),
];
