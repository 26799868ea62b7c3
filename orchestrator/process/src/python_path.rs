//! The package `webloop` for programs of somebody's own: one in Python may import it, installed or not.

use std::ffi::OsString;
use std::fs::File;
use std::io;

/// The package as an archive in memory. A program inherits it, so it has to be open until that has started; one that
/// starts further programs needs it for as long as it runs.
pub(crate) struct PythonPath(File);

impl PythonPath {
    pub(crate) fn new() -> io::Result<PythonPath> {
        python::package().map(PythonPath).map_err(io::Error::other)
    }

    /// The variable of the environment by which Python finds it.
    pub(crate) fn variable(&self) -> (&'static str, OsString) {
        ("PYTHONPATH", python::path(&self.0))
    }
}
