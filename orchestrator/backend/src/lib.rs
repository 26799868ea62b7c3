//! Runs a cell and judges whether its link held. It does not evaluate what the loop did.
//!
//! - [`run_cell`]: runs a cell of a plan on a [`Backend`] with a [`Player`]; [`record::Made`] is what comes
//!   of it, and writes its manifest.
//! - `course`: starts the parts and waits for them, in the same way everywhere; `schedule` has the
//!   times.
//! - `role`: the settings that plant, controller and link receive; `texts`, those of the plan that they are made from.
//! - `site`: where the parts live. `netns` runs the roles as processes in a [`Lab`] of namespaces.
//!   `attach` has [`Agents`] start them elsewhere, as `remote_part` parts, and joins the two halves of
//!   each echo (`sighting`).
//! - `link_check`, `evidence`: the link's echoes and certificate; [`probe()`] does only this.
//! - `pulse` shows when the machine stood still; `rows` has those by which a run is judged.
//! - `report`, [`machine()`]: what a manifest says about roles and machine.
//! - [`ability`]: what this machine can do. [`Awake`] keeps its processors from halting.

pub mod ability;
mod again;
mod agents;
mod attach;
mod awake;
mod course;
mod error;
mod evidence;
mod lab;
mod link_check;
mod machine;
mod netns;
mod own;
mod own_plant;
mod patience;
mod player;
mod probe;
mod pulse;
mod remote_part;
mod report;
mod role;
mod rows;
mod run;
mod schedule;
mod sighting;
mod simulated;
mod site;
mod texts;
mod timings;
mod unable;
mod virtual_time;

pub use agents::{Agents, BadAgents};
pub use attach::dismiss;
pub use awake::Awake;

pub use again::{Again, judge_again};
pub use error::RunError;
pub use lab::Lab;
pub use machine::machine;
pub use own_plant::{hidden, start_plant, start_simulated};
pub use player::Player;
pub use probe::{Probed, probe};
pub use process::spawn;
pub use role::{ControllerRole, LinkRole, PlantRole, settings_schema};
pub use run::{Attempt, Backend, cell_folder, run_cell};
pub use schedule::{AFTER_OPENING_NS, lead_ns, overhead_ns, stagger_ns};
pub use timings::{InvalidTimings, Rates, TimedProgram, Timings};
pub use virtual_time::Virtual;
