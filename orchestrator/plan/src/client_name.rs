//! The names of webloop's clients in plans, tables and commands, which no program of one's own may have.

pub(crate) const NATIVE: &str = "native";
pub(crate) const PYTHON: &str = "python";
pub(crate) const CHROMIUM: &str = "chromium";
pub(crate) const FIREFOX: &str = "firefox";

/// All of them.
pub(crate) const NAMES: [&str; 4] = [NATIVE, PYTHON, CHROMIUM, FIREFOX];
