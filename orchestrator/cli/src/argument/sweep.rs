//! Arguments of sweeps: a loop over a grid of conditions and settings.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;
use std::sync::LazyLock;

use anyhow::Context;
use clap::Args;

use super::Progress;

/// What a sweep can be: a built-in one, or a file.
static SWEEP: LazyLock<String> = LazyLock::new(|| {
    let names: Vec<&str> = sweep::SWEEPS.iter().map(|(name, _)| *name).collect();
    format!(
        "{}, or the path of a sweep; without it they are listed",
        names.join(", ")
    )
});

#[derive(Debug, Args)]
pub(crate) struct Sweep {
    #[arg(help = SWEEP.as_str())]
    pub(crate) sweep: Option<String>,
    /// Fix an axis to one value, such as kp=0.17 (repeatable)
    #[arg(long, value_name = "AXIS=VALUE", value_parser = fixed)]
    pub(crate) fix: Vec<(sweep::Axis, String)>,
    /// The seed; equal seeds give equal links
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Use the timings in this file from `calibrate` instead of the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) timing: Option<PathBuf>,
    /// How many runs at a time, instead of one for each core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Print the axes, and run nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print the JSON schema of sweep files, and nothing else
    #[arg(long)]
    pub(crate) schema: bool,
    /// Results folder; a folder with the same sweep is continued
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// How progress is shown
    #[arg(long, value_enum, default_value_t = Progress::Auto, value_name = "HOW")]
    pub(crate) progress: Progress,
}

/// Parses an axis and the value that it is fixed to.
fn fixed(text: &str) -> anyhow::Result<(sweep::Axis, String)> {
    let (axis, value) = text
        .split_once('=')
        .context("write an axis and its value, such as kp=0.17")?;
    Ok((axis.trim().parse()?, value.trim().to_owned()))
}
