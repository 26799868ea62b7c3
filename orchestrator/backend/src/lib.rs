//! Runs a cell and says whether its link held; reads nothing of what the loop did.
//!
//! - [`run_cell`]: a cell from its plan to its [`Manifest`], on a [`Backend`] and by a [`Player`].
//! - `course`: what is started when and waited for, the same everywhere; `schedule` has the times.
//! - `client`: a cell's client as a role.
//! - `site`: where the parts live. `netns` has a [`Lab`] of namespaces and the roles as processes
//!   in them; `attach` has [`Agents`] that start them elsewhere, as `distant` parts, and echoes
//!   with two halves (`sighting`).
//! - `proof`, `evidence`: the link's echoes and certificate; [`probe()`] is that alone.
//! - `folder`, `report`, [`Machine`]: what a manifest says about files, roles and machine.
//! - [`ability`]: what this machine can do.

pub mod ability;
mod agents;
mod attach;
mod client;
mod course;
mod distant;
mod error;
mod evidence;
mod folder;
mod lab;
mod machine;
mod manifest;
mod netns;
mod player;
mod probe;
mod proof;
mod report;
mod run;
mod schedule;
mod sighting;
mod site;

pub use agents::Agents;
pub use attach::dismiss;

pub use agent::spawn;
pub use error::RunError;
pub use folder::{FileFact, write_whole};
pub use lab::Lab;
pub use machine::Machine;
pub use manifest::Manifest;
pub use player::Player;
pub use probe::{Probed, probe};
pub use run::{Backend, cell_folder, manifest, run_cell};
pub use schedule::overhead_ns;
