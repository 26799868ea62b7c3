//! Arguments of the report on a results folder.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use plan::Clause;

#[derive(Debug, Args)]
pub(crate) struct Report {
    /// A results folder, from any machine
    pub(crate) folder: PathBuf,
    /// Write the report here instead of into the folder's `report`; the folder stays unchanged
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Exit with 1 unless the runs show this too: holds, "settling <= 400ms", "sent >= 99% in 90% at 95%"
    #[arg(long, value_name = "CLAUSE")]
    pub(crate) require: Vec<Clause>,
    /// Open the page in the desktop's browser
    #[arg(long)]
    pub(crate) open: bool,
    /// Draw each figure as PNG too, for slides
    #[arg(long)]
    pub(crate) png: bool,
    /// Add the tables, figures and claims of this publication, whatever the experiment
    #[arg(long, value_enum, value_name = "PUBLICATION")]
    pub(crate) with: Option<Publication>,
}

/// A publication whose tables, figures and claims can be recomputed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Publication {
    // S. L. Remy, "Web Standards as Standard Pieces in Robotics". The experiment `paper` has it anyway.
    Paper,
}
