//! Arguments for looking at results.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, ValueEnum};
use plan::Clause;

#[derive(Debug, Args)]
pub(crate) struct Show {
    /// A results folder
    pub(crate) folder: PathBuf,
    /// How it is printed
    #[arg(long, value_enum, default_value_t = ShowFormat::Table)]
    pub(crate) format: ShowFormat,
    /// Include disturbed runs in medians
    #[arg(long)]
    pub(crate) with_disturbed: bool,
    /// Do not fail because cells of the plan have not been run, as in one job of several
    #[arg(long)]
    pub(crate) allow_missing: bool,
    /// Exit with 1 unless the runs show this too: holds, "settling <= 400ms", "sent >= 99% in 90% at 95%"
    #[arg(long, value_name = "CLAUSE")]
    pub(crate) require: Vec<Clause>,
}

/// How a results folder is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShowFormat {
    /// For people
    Table,
    /// Every figure, as in summary.csv
    Csv,
    /// As CSV, the lateness of each message against its schedule
    Lateness,
    /// As CSV, histograms of the time between arrivals, in ms and in ticks of the plant
    Intervals,
    /// As CSV, each message's round trip and its sample's delay in parts
    Budget,
}

#[derive(Debug, Args)]
pub(crate) struct Collect {
    /// Results folders of one plan, or folders that contain them
    #[arg(required = true, value_name = "DIR")]
    pub(crate) folders: Vec<PathBuf>,
    /// Where to merge them; may be one of them
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// The results folder to compare with
    pub(crate) a: PathBuf,
    /// The results folder that may be worse
    pub(crate) b: PathBuf,
    /// Smallest change that matters, in percent
    #[arg(long = "change", value_name = "PERCENT", default_value = "5", value_parser = percent)]
    pub(crate) change_pct: f64,
    /// Ignore missing and incomplete runs instead of failing
    #[arg(long)]
    pub(crate) allow_missing: bool,
    /// Let pass what is not to fail, repeatable: missing, incomplete and damaged runs of cells whose id contains PATTERN, or matches it if it has a *; or `undecided`, that it cannot be told whether B is worse
    #[arg(long, value_name = "PATTERN|undecided")]
    pub(crate) allow: Vec<String>,
    /// How the comparison is printed
    #[arg(long, value_enum, default_value_t = CompareFormat::Table)]
    pub(crate) format: CompareFormat,
}

#[derive(Debug, Args)]
pub(crate) struct Agree {
    /// A results folder, such as one in virtual time
    pub(crate) a: PathBuf,
    /// The results folder that it should agree with, such as one over real sockets
    pub(crate) b: PathBuf,
    /// Ignore missing and incomplete runs instead of failing
    #[arg(long)]
    pub(crate) allow_missing: bool,
    /// How the agreement is printed
    #[arg(long, value_enum, default_value_t = AgreeFormat::Table)]
    pub(crate) format: AgreeFormat,
}

/// How an agreement is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AgreeFormat {
    /// For people
    Table,
    /// All of it, for other programs
    Json,
}

/// How a comparison is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CompareFormat {
    /// For people
    Table,
    /// A row for each measure of each group
    Csv,
    /// All of it, for other programs
    Json,
}

/// Parses a percentage that serves as a limit.
fn percent(text: &str) -> anyhow::Result<f64> {
    text.parse::<f64>()
        .ok()
        .filter(|percent| (0.0..=1000.0).contains(percent))
        .context("give a number of percent from 0 to 1000")
}
