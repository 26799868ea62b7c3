//! Arguments of the report on a results folder.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct Report {
    /// A results folder, from any machine
    pub(crate) folder: PathBuf,
    /// Write the report here instead of into the folder's `report`; the folder stays unchanged
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
