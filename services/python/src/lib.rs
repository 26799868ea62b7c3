//! The controller in Python, carried in this binary.
//!
//! * [`run`]: replaces this process by the interpreter that runs the controller.
//! * [`package`], [`path`]: the package as an archive, and where other Python programs find it.
//! * [`version`]: the version of that interpreter.
//!
//! The controller itself is the package `webloop` beside `src`, which also runs without this crate,
//! and of which it is one use: others write their own controllers with it. This crate embeds the
//! package's files in the binary and passes them on in memory: nothing is installed, and nothing is
//! left on disk.
#![forbid(unsafe_code)]

mod archive;
mod interpreter;

pub use archive::InvalidArchive;
pub use interpreter::{Error, package, path, run, version};
