//! Arguments for links by themselves: explaining, checking, probing.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::path::PathBuf;

use anyhow::anyhow;
use clap::{Args, Subcommand, ValueEnum};

use super::Player;

#[derive(Debug, Subcommand)]
pub(crate) enum LinkCommand {
    /// List the built-in links
    List,
    /// Say in plain words what a link does, and what a ping through it will see
    Show(LinkShow),
    /// Check a profile file
    Lint(LinkLint),
    /// Print the JSON schema of profile files
    Schema,
}

#[derive(Debug, Args)]
pub(crate) struct LinkShow {
    /// A built-in topology, or the path of a profile file
    pub(crate) profile: String,
    /// Print its file instead, to save and change
    #[arg(long, conflicts_with = "tc")]
    pub(crate) toml: bool,
    /// Print the tc commands for one direction, as a script to read or replay by hand; webloop itself feeds them to one `tc -batch -`, each at its time
    #[arg(long)]
    pub(crate) tc: bool,
    /// The link's seed
    #[arg(long, default_value_t = 1, requires = "tc")]
    pub(crate) seed: u64,
    /// Which way
    #[arg(long, value_enum, default_value_t = Way::Up, requires = "tc")]
    pub(crate) way: Way,
    /// How long a time of the link to print
    #[arg(long = "for", default_value = "10s", value_name = "TIME", value_parser = span, requires = "tc")]
    pub(crate) span_ns: u64,
}

fn span(text: &str) -> anyhow::Result<u64> {
    let span_ns = text::duration_ns(text, 1..=60 * text::MINUTE_NS);
    span_ns.map_err(|_| anyhow!("give a time up to an hour, like 10s"))
}

#[derive(Debug, Args)]
pub(crate) struct LinkLint {
    /// Profile files
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Probe {
    /// A built-in topology, or the path of a profile file
    pub(crate) topology: String,
    /// How many echo requests to send
    #[arg(short, long, default_value_t = 30, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) count: u32,
    /// Seconds between two requests
    #[arg(short, long, default_value_t = 1.0, value_name = "SECONDS", value_parser = interval)]
    pub(crate) interval: f64,
    /// The link's seed
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// What plays the link
    #[arg(long, value_enum, default_value_t = Player::Auto, value_name = "WHO")]
    pub(crate) player: Player,
    /// Print only the summary
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

fn interval(text: &str) -> anyhow::Result<f64> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.001..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(anyhow!("give seconds between 0.001 and 3600")),
    }
}

/// A direction of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Way {
    /// From controller to plant
    Up,
    /// From plant to controller
    Down,
}

impl From<Way> for ::link::Way {
    fn from(way: Way) -> Self {
        match way {
            Way::Up => ::link::Way::Up,
            Way::Down => ::link::Way::Down,
        }
    }
}
