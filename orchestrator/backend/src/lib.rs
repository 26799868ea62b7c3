//! Runs a cell and says whether its link held; reads nothing of what the loop did.
//!
//! - [`run_cell`]: a cell from its plan to its [`Manifest`], on a [`Backend`] and by a [`Player`].
//! - `course`: what is started when and waited for, the same everywhere; `schedule` has the times.
//! - `role`: what plant, controller and link are told.
//! - `site`: where the parts live. `netns` has a [`Lab`] of namespaces and the roles as processes
//!   in them; `attach` has [`Agents`] that start them elsewhere, as `remote_part` parts, and echoes
//!   with two halves (`sighting`).
//! - `link_check`, `evidence`: the link's echoes and certificate; [`probe()`] is that alone.
//! - `pulse`, `record`: what a machine that stood still says, and the rows by which a run is judged.
//! - `folder`, `report`, [`machine()`]: what a manifest says about files, roles and machine.
//! - [`ability`]: what this machine can do.

pub mod ability;
mod agents;
mod attach;
mod course;
mod error;
mod evidence;
mod folder;
mod lab;
mod link_check;
mod machine;
mod netns;
mod player;
mod probe;
mod pulse;
mod record;
mod remote_part;
mod report;
mod role;
mod run;
mod schedule;
mod sighting;
mod simulated;
mod site;
mod timings;

pub use agents::Agents;
pub use attach::dismiss;

pub use agent::spawn;
pub use error::RunError;
pub use folder::{move_aside, write_whole};
pub use lab::Lab;
pub use machine::machine;
pub use manifest::Manifest;
pub use player::Player;
pub use probe::{Probed, probe};
pub use role::{ControllerRole, LinkRole, PlantRole, settings_schema};
pub use run::{Attempt, Backend, cell_folder, manifest, run_cell};
pub use schedule::{AFTER_EPOCH_NS, lead_ns, overhead_ns, stagger_ns};
pub use timings::{InvalidTimings, Program, Rates, Timings};
