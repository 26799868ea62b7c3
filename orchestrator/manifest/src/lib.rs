//! What a run says about itself: a [`Manifest`], which has the reports of plant, controller, page and
//! link, the link's certificate, and what the run's judges saw, each in its own type.
//!
//! [`PlantReport`] and [`ControllerReport`] say which role leaves which report; the reports themselves
//! are in [`endpoint::report`] and [`certificate`]. No clock, file or thread: back-ends and analysis
//! look at the machine and read files.
#![forbid(unsafe_code)]

mod fact;
#[allow(clippy::module_inception)]
mod manifest;
mod report;

pub use fact::{FileFact, Tally};
pub use manifest::{Machine, Manifest, NotAManifest};
pub use report::{ControllerReport, ModelController, ModelPlant, PlantReport};
