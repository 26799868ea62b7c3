//! Arguments for dividing an experiment into jobs.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use plan::Shard;

use super::campaign::{Choice, EXPERIMENT};

#[derive(Debug, Args)]
pub(crate) struct Matrix {
    #[arg(default_value = "smoke", help = EXPERIMENT.as_str())]
    pub(crate) experiment: String,
    #[command(flatten)]
    pub(crate) choice: Choice,
    /// The campaign's seed; equal seeds give equal links
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Take the full experiment, not its scaled form
    #[arg(long)]
    pub(crate) full: bool,
    /// N jobs that take about equally long, instead of one for each topology
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Shard::MOST)), conflicts_with = "shard")]
    pub(crate) shards: Option<u32>,
    /// How the jobs are printed
    #[arg(long, value_enum, default_value_t = MatrixFormat::List)]
    pub(crate) format: MatrixFormat,
    /// Write the plan that the jobs share, for `webloop run FILE --cells I,...`
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: Option<PathBuf>,
    /// Print the JSON schema of experiment files, or of plans, and nothing else
    #[arg(long, value_enum, value_name = "WHAT", num_args = 0..=1, require_equals = true, default_missing_value = "experiment")]
    pub(crate) schema: Option<Document>,
}

/// What a JSON schema describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Document {
    /// An experiment, as it is written
    Experiment,
    /// What it comes to, as --plan writes it
    Plan,
}

/// How jobs are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MatrixFormat {
    /// For people
    List,
    /// One line for `strategy.matrix` of a GitHub workflow
    Github,
    /// For other programs
    Json,
}
