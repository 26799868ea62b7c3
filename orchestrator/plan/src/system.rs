//! A system: a plant, the law that controls it, and the reference, described in TOML.
//!
//! - [`System`] is a system, read and found valid; the built-in ones are in `systems/`;
//! - [`PlantModel`] is its plant: a linear model, or a program of somebody's own;
//! - [`Holding`] is what of its outputs counts as holding: band, limits, overshoot, effort;
//! - [`Loop`] is a system at a sample time: what a plant steps, and what a controller runs;
//! - [`Design`] is the law as numbers, in the form in which clients in other languages get it.
//!
//! `file` has the keys of the TOML, `plant`, `law` and `feedback` interpret them. The caller provides the text:
//! there is no file, clock or socket here. `control` has what plants and laws do.

mod around;
mod description;
mod design;
mod fault;
mod feedback;
mod file;
mod holding;
mod law;
mod limits;
mod obstacle;
mod plant;
mod program;
mod reference;
mod sampled;

pub use description::System;
pub use design::{Design, Limits, Matrices, Model, PidNumbers};
pub use file::schema;
pub use holding::{Band, Holding};
pub use obstacle::Obstacle;
pub use plant::PlantModel;
pub use program::Program;
pub use sampled::{Loop, Unfit};
