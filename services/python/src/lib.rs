//! The controller in Python, carried in this binary.
//!
//! * [`run`]: replaces this process by the interpreter that runs the controller.
//! * [`version`]: the version of that interpreter.
//!
//! The controller itself is the package `webloop_controller` beside `src`, which also runs without
//! this crate. This crate embeds its files in the binary and passes them on in memory: nothing is
//! installed, and nothing is left on disk.
#![forbid(unsafe_code)]

mod archive;
mod interpreter;

pub use archive::InvalidArchive;
pub use interpreter::{Error, run, version};
