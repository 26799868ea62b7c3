//! The command line. Nothing is looked up here, and nothing is checked beyond what the types' own parsers check.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::group::Group;

/// Measures webloop beside its limits and its peers on this machine
#[derive(Debug, Parser)]
#[command(
    name = "webloop-bench",
    version,
    max_term_width = 100,
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true
)]
#[command(
    after_help = "It measures the binary `webloop` as it was built last: cargo build --release\n\nExit codes: 0 fine, \
1 something failed, 2 wrong usage or no webloop, 130 interrupted."
)]
pub(crate) struct BenchOptions {
    #[command(subcommand)]
    pub(crate) command: Option<BenchCommand>,
    /// What to measure: step, rate, tick, delay, stream, virtual, rows, cell, memory, report, browser, compose
    /// (default: all, in about nine minutes)
    #[arg(value_name = "TABLE")]
    pub(crate) tables: Vec<Group>,
    #[command(flatten)]
    pub(crate) settings: Settings,
    /// Where bench.csv, bench.txt and machine.json go (default: a new folder in results)
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// The webloop to measure (default: the one beside this program)
    #[arg(long, value_name = "PATH")]
    pub(crate) webloop: Option<PathBuf>,
}

/// How to measure.
#[derive(Debug, Args)]
pub(crate) struct Settings {
    /// How often each is measured; ratios are taken within one repetition
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) times: u32,
    /// How long one is measured at a time, ms
    #[arg(long, default_value_t = 2000, value_name = "MS", value_parser = clap::value_parser!(u64).range(100..=60_000))]
    pub(crate) measure_ms: u64,
}

/// What this program does beside measuring.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// An end that a peer is measured with: what is measured starts it
    #[command(hide = true)]
    End {
        /// echo, echo PRIORITY, hyper, ping ADDRESS EVERY_MS COUNT, or send ADDRESS:PORT MS
        #[arg(required = true)]
        words: Vec<String>,
    },
}
