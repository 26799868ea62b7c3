//! What a run leaves: the folder of a cell, who may write it, what its manifest says, and how it is read.
//!
//! - [`file`](mod@file): opens and writes files of such a folder, and nothing in their place; [`lock`](mod@lock): one process at a time;
//! - [`folder`]: makes room for a cell and writes its files; [`made`]: a cell that has been run, until its
//!   manifest is there;
//! - [`Manifest`] has the reports of plant, controller, page and link, the link's certificate, and what the
//!   run's judges saw, each in its own type. [`PlantReport`] and [`ControllerReport`] say which role leaves which
//!   report; the reports themselves are in [`endpoint::report`] and [`certificate`](link::certificate);
//! - [`FileFact`], [`Tally`]: length and checksum of a file; [`Held`]: rows that are in memory still;
//! - [`rows`]: reads a file of rows in one streaming pass, and counts the last lines that killed runs left torn;
//! - [`whole`]: whether a folder matches its manifest and its plan; [`order`]: whether all of its rows are there;
//!   [`Damage`] is a file that does not.
//!
//! The names of files are in [`plan::file_name`], since a plan must not use them for its own. Back-ends write
//! folders and analysis reads them; neither knows the other, and both know this. What rows say of a loop is
//! analysis's to say, and how a run is judged its judges'.
#![forbid(unsafe_code)]

mod damage;
mod fact;
pub mod file;
pub mod folder;
mod held;
pub mod lock;
pub mod made;
mod manifest;
pub mod order;
pub mod report;
pub mod rows;
pub mod whole;

pub use damage::Damage;
pub use fact::{FileFact, Tally};
pub use held::Held;
pub use made::Made;
pub use manifest::{Machine, Manifest, NotAManifest, Unreadable};
pub use report::{ControllerReport, ModelController, ModelPlant, PlantReport};
pub use rows::ReadError;
