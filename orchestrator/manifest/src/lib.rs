//! What a run says of itself: a [`Manifest`], which has the reports of plant, controller, page and
//! link, the link's certificate, and what the run's judges saw, each in its own type.
//!
//! Which role leaves which report is told in [`PlantReport`] and [`ControllerReport`]; the reports
//! themselves are in [`endpoint::report`] and [`certificate`]. No clock, file or thread: looking at
//! a machine and reading files is the back-ends' and the analysis'.
#![forbid(unsafe_code)]

mod fact;
#[allow(clippy::module_inception)]
mod manifest;
mod report;

pub use fact::{FileFact, Tally};
pub use manifest::{Machine, Manifest};
pub use report::{ControllerReport, ModelController, ModelPlant, PlantReport};
