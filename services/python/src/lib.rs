//! The controller in Python, from this binary.
//!
//! * [`run`]: becomes the interpreter that runs the controller.
//! * [`version`]: which interpreter that is.
//!
//! The controller itself is the package `webloop_controller` beside `src`, and
//! can be run without this crate. Here its files are carried in the binary and
//! handed over in memory: nothing is installed, and nothing is left on disk.
#![forbid(unsafe_code)]

mod archive;
mod interpreter;

pub use archive::InvalidArchive;
pub use interpreter::{Error, run, version};
