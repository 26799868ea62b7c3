//! Arguments of the test of a controller or a plant against its contract.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use endpoint::{SampleTime, Signals};

#[derive(Debug, Args)]
pub(crate) struct Conform {
    /// The controller, or the plant: its program and arguments
    #[arg(last = true, required_unless_present = "list", value_name = "COMMAND")]
    pub(crate) command: Vec<String>,
    /// Test a plant: a program that reads u and prints y
    #[arg(long)]
    pub(crate) plant: bool,
    /// How many inputs the plant has, 1 or 2
    #[arg(long, value_name = "N", default_value = "1", requires = "plant", value_parser = inputs)]
    pub(crate) inputs: usize,
    /// Sample time, from 1ms to 100ms
    #[arg(long, default_value = "10ms", value_name = "TIME", value_parser = sample_time)]
    pub(crate) h: SampleTime,
    /// Write the outcomes as JUnit XML too
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,
    /// Keep each trial's folder, with the controller's log, in this new folder
    #[arg(long, value_name = "DIR", conflicts_with = "plant")]
    pub(crate) keep: Option<PathBuf>,
    /// List the trials and what each asks, and run nothing
    #[arg(long)]
    pub(crate) list: bool,
}

fn inputs(text: &str) -> anyhow::Result<usize> {
    let inputs = text.parse::<usize>().ok();
    let known = inputs.filter(|inputs| (1..=Signals::MOST).contains(inputs));
    known.context("give 1 or 2")
}

fn sample_time(text: &str) -> anyhow::Result<SampleTime> {
    const MS: u64 = 1_000_000;
    let h: SampleTime = text.parse()?;
    // A trial lasts some seconds, so a longer h leaves too few messages to judge.
    if (MS..=100 * MS).contains(&h.ns()) {
        Ok(h)
    } else {
        bail!("give a time from 1ms to 100ms, like 10ms")
    }
}
