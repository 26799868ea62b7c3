//! A system: a plant, the law that controls it, and the reference, described in TOML.
//!
//! - [`System`] is one, read and found valid; those that the binary carries are in `systems/`;
//! - [`Loop`] is one at a sample time: what a plant steps, and what a controller runs;
//! - [`Design`] is the law as numbers, in the form that clients in other languages get.
//!
//! What the words of the TOML are is in `file`, what is made of them in `plant` and `law`. Where the
//! text comes from is left to the caller: there is no file, clock or socket here. What plants and
//! laws do is in `control`.
#![forbid(unsafe_code)]

mod design;
mod fault;
mod file;
mod law;
mod limits;
mod obstacle;
mod plant;
mod system;

pub use design::{Design, Limits, Model, PidNumbers};
pub use fault::Fault;
pub use file::schema;
pub use obstacle::Obstacle;
pub use system::{Loop, NotOpened, System, Unfit, is_name};
