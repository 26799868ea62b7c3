//! The report on a results folder.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct Report {
    /// A results folder, wherever it came from
    pub(crate) folder: PathBuf,
    /// Where the report goes, instead of the folder's own `report`; the folder is then left as it is
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
