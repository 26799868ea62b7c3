//! Tests whether a controller, or a plant, keeps the contract of `docs/contract.md`.
//!
//! - [`Trial`] is one test: what it asks, and what its plant does meanwhile.
//! - `plant` is a plant that follows a trial's script: it listens late, holds answers back, closes
//!   connections, refuses. `exchange` has the motor and what was heard; `route` is HTTP, `socket` the
//!   WebSocket.
//! - `record` is what a trial saw of a controller. `check` compares it with the contract and finds each
//!   [`Breach`].
//! - [`run()`] runs trials, several at once. [`TrialResult`] is the result of one; [`table`] and [`junit()`]
//!   print them.
//!
//! `stepped` has the trials of a plant, which are other ones: it answers a u with a y, on a pipe.
//!
//! The caller starts the controllers and the plants. There is no link here and no namespace: what a run over a link
//! demands of a controller is judged by the run.
#![forbid(unsafe_code)]

mod breach;
mod check;
mod error;
mod exchange;
mod junit;
mod outcome;
mod plant;
mod plant_fault;
mod record;
mod route;
mod run;
mod socket;
mod stepped;
mod trial;

pub use breach::Breach;
pub use error::Error;
pub use junit::junit;
pub use outcome::{TrialResult, Verdict, table};
pub use plant_fault::PlantFault;
pub use run::{NAME, Start, run};
pub use stepped::{PLANT_TRIALS, PlantTrial, StartPlant, run_plant};
pub use trial::Trial;
