//! Runs a cell and says whether its link held; reads nothing of what the loop did.
//!
//! - [`run_cell`]: a cell from its plan to its [`Manifest`]. `netns` is the back-end: a [`Lab`]
//!   of namespaces, the roles as processes in them (`role`, [`spawn`]), the times (`schedule`).
//! - `proof`: the link's echoes and certificate; [`probe()`] is that alone.
//! - `folder`, [`Machine`]: what a manifest says about files and machine.
//! - [`ability`]: what this machine can do.

pub mod ability;
mod error;
mod folder;
mod lab;
mod machine;
mod manifest;
mod netns;
mod probe;
mod proof;
mod role;
mod run;
mod schedule;
pub mod spawn;

pub use error::RunError;
pub use folder::{FileFact, write_whole};
pub use lab::Lab;
pub use machine::Machine;
pub use manifest::Manifest;
pub use probe::{Probed, probe};
pub use run::{cell_folder, manifest, run_cell};
pub use schedule::overhead_ns;
