//! Arguments for systems by themselves: listing, showing, checking.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum SystemCommand {
    /// List the built-in systems
    List,
    /// Print a system's TOML, as a start for your own
    Show(SystemShow),
    /// Check system files
    Lint(SystemLint),
    /// Print the JSON schema of system files
    Schema,
}

#[derive(Debug, Args)]
pub(crate) struct SystemShow {
    /// A built-in system, or the path of a system file
    pub(crate) system: String,
}

#[derive(Debug, Args)]
pub(crate) struct SystemLint {
    /// System files
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
}
