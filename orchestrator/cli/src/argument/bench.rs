//! Arguments of measurements of webloop itself.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// What to measure: step, rate, tick, delay, stream, virtual, rows, cell, memory, report, browser, compose
    /// (default: all, in about nine minutes)
    #[arg(value_name = "TABLE")]
    pub(crate) tables: Vec<bench::Group>,
    /// How often each is measured; ratios are taken within one repetition
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) times: u32,
    /// How long one is measured at a time, ms
    #[arg(long, default_value_t = 2000, value_name = "MS", value_parser = clap::value_parser!(u64).range(100..=60_000))]
    pub(crate) measure_ms: u64,
    /// Where bench.csv, bench.txt and machine.json go (default: a new folder in results)
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct ServeEnd {
    /// echo, hyper, ping ADDRESS EVERY_MS COUNT, or send ADDRESS:PORT MS
    #[arg(required = true)]
    pub(crate) words: Vec<String>,
}
