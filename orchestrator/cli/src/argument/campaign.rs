//! Arguments for running experiments.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::LazyLock;

use anyhow::Context;
use clap::{Args, ValueEnum};
use endpoint::SampleTime;
use plan::sweep::Axis;
use plan::{Clause, EXPERIMENTS, RepeatCount, Selection, Shard};

/// What an experiment can be: a built-in one, or a file.
pub(super) static EXPERIMENT: LazyLock<String> = LazyLock::new(|| {
    let names: Vec<&str> = EXPERIMENTS.iter().map(|(name, _)| *name).collect();
    format!(
        "{}, or the path of an experiment or of a plan.json",
        names.join(", ")
    )
});

#[derive(Debug, Clone, Args)]
pub(crate) struct Run {
    #[arg(default_value = "smoke", help = EXPERIMENT.as_str())]
    pub(crate) experiment: String,
    /// A first table in 20 s: the experiment `quick`
    #[arg(long, conflicts_with = "experiment")]
    pub(super) quick: bool,
    #[command(flatten)]
    pub(crate) choice: Choice,
    /// Run the full experiment, not its scaled form (paper: 600 s instead of 120)
    #[arg(long)]
    pub(crate) full: bool,
    /// How many cells run at a time, instead of the experiment's number; they share the processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    pub(crate) jobs: Option<u16>,
    #[command(flatten)]
    pub(crate) instead: Replacement,
    /// Fix an axis of a sweep to one value, such as kp=0.17 (repeatable)
    #[arg(long, value_name = "AXIS=VALUE", value_parser = fixed)]
    pub(crate) fix: Vec<(Axis, String)>,
    /// The campaign's seed; equal seeds give equal links
    #[arg(long, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Where the cells run
    #[arg(long, value_enum, default_value_t = Backend::Netns, value_name = "WHERE")]
    pub(crate) backend: Backend,
    /// With --backend compose, use the images as they are
    #[arg(long)]
    pub(crate) no_build: bool,
    /// What plays the link
    #[arg(long, value_enum, default_value_t = Player::Auto, value_name = "WHO")]
    pub(crate) player: Player,
    /// Keep this machine's processors from halting during the runs, for the least lateness: needs root, uses
    /// energy, and may cost pauses on a rented machine; `doctor` measures whether it pays
    #[arg(long)]
    pub(crate) awake: bool,
    /// With --backend sim, use the timings in this file from `calibrate` instead of the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) timing: Option<PathBuf>,
    /// Maximum number of tries for a cell that is disturbed; each try is kept
    #[arg(long, value_name = "N", default_value_t = Run::TRIES, value_parser = clap::value_parser!(u8).range(1..))]
    pub(crate) tries: u8,
    /// Print the cells and how long they will take, and run nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Make no report at the end
    #[arg(long)]
    pub(crate) no_report: bool,
    /// Serve the report while it fills, on this address of this machine
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:0")]
    pub(crate) live: Option<SocketAddr>,
    /// Results folder; a folder with the same plan is continued
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Continue the newest folder in results/ that has this plan
    #[arg(long, conflicts_with = "out")]
    pub(crate) resume: bool,
    /// Repeat incomplete and damaged runs only, in --out or the newest folder of this plan
    #[arg(long)]
    pub(crate) failed: bool,
    /// How progress is shown
    #[arg(long, value_enum, default_value_t = Progress::Auto, value_name = "HOW")]
    pub(crate) progress: Progress,
    /// Exit with 1 unless the runs show this too: holds, "settling <= 400ms", "sent >= 99% in 90% at 95%"
    #[arg(long, value_name = "CLAUSE")]
    pub(crate) require: Vec<Clause>,
    /// Set by a gate.
    #[arg(skip)]
    pub(crate) undecided: Undecided,
}

/// What every block of cells, or a sweep, has in place of its own.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Replacement {
    /// Topologies or profile files instead of the experiment's (repeatable)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) topology: Vec<String>,
    /// Clients instead of the experiment's (repeatable)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) client: Vec<String>,
    /// Systems or system files instead of the experiment's (repeatable)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) system: Vec<String>,
    /// Sample times instead of the experiment's (repeatable)
    #[arg(long, value_name = "TIME,...", value_delimiter = ',')]
    pub(crate) h: Vec<SampleTime>,
    /// How long each run lasts, instead of the experiment's
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(crate) duration: Option<String>,
    /// How many runs of each, instead of the experiment's
    #[arg(long, value_name = "N")]
    pub(crate) repeats: Option<RepeatCount>,
}

impl Run {
    /// How often a cell that is disturbed is tried, if nothing else is asked.
    pub(crate) const TRIES: u8 = 3;

    /// Name or path of the experiment to run.
    pub(crate) fn experiment(&self) -> &str {
        if self.quick {
            "quick"
        } else {
            &self.experiment
        }
    }
}

/// A time, as an experiment has it.
pub(super) fn duration(text: &str) -> anyhow::Result<String> {
    super::time(text).map(|_| text.to_owned())
}

/// A seed.
pub(super) fn seed(text: &str) -> anyhow::Result<u64> {
    text.parse()
        .map_err(|_| anyhow::anyhow!("give a whole number from 0 to {}", u64::MAX))
}

/// Parses an axis and the value that it is fixed to.
fn fixed(text: &str) -> anyhow::Result<(Axis, String)> {
    let (axis, value) = text
        .split_once('=')
        .context("write an axis and its value, such as kp=0.17")?;
    Ok((axis.trim().parse()?, value.trim().to_owned()))
}

/// What to make of an answer that cannot be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Undecided {
    /// It fails.
    #[default]
    Fails,
    /// It passes, as `--allow undecided` asks.
    Passes,
}

/// The word behind `--allow` for an answer that cannot be told.
pub(crate) const UNDECIDED: &str = "undecided";

#[derive(Debug, Args)]
pub(crate) struct Gate {
    #[command(flatten)]
    pub(crate) run: Run,
    /// Stop after virtual time
    #[arg(long)]
    pub(crate) sim_only: bool,
    /// Let pass what is not to fail: that a clause with a confidence cannot be told from so few runs
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) allow: Option<Allowed>,
}

/// What a gate lets pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Allowed {
    /// An answer that cannot be told
    Undecided,
}

/// Where cells run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Backend {
    /// In network namespaces of this machine
    Netns,
    /// In containers, through Docker Compose
    Compose,
    /// By agents that already run at the addresses in WEBLOOP_AGENTS
    Attach,
    /// In virtual time: nothing is started, and a seed gives the same rows everywhere
    Sim,
}

/// What plays a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Player {
    /// In namespaces user; in containers tc, if the kernel has netem
    Auto,
    /// webloop itself, packet by packet
    User,
    /// The kernel's netem, changed in time
    Tc,
}

impl From<Player> for backend::Player {
    fn from(player: Player) -> Self {
        match player {
            Player::Auto => backend::Player::Auto,
            Player::User => backend::Player::User,
            Player::Tc => backend::Player::Tc,
        }
    }
}

/// The word for a choice on the command line.
pub(crate) fn word(choice: &impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Which cells.
#[derive(Debug, Clone, Args)]
pub(crate) struct Choice {
    /// Only cells whose id contains PATTERN, or matches it if it has a * (repeatable)
    #[arg(long, value_name = "PATTERN")]
    pub(crate) only: Vec<String>,
    /// Only cells with these indices, like 0,3,4, as `matrix` gives them
    #[arg(
        long,
        value_name = "I,...",
        value_delimiter = ',',
        conflicts_with = "only"
    )]
    pub(crate) cells: Vec<usize>,
    /// Only share I of N of these cells, like 2/7; all shares take about equally long
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
}

impl Choice {
    /// The cells of a plan that it selects, before they are divided into shards.
    pub(crate) fn selection(&self) -> Selection {
        match (self.only.as_slice(), self.cells.as_slice()) {
            ([], []) => Selection::All,
            ([], indices) => Selection::Numbered(indices.to_vec()),
            (patterns, _) => Selection::Matching(patterns.to_vec()),
        }
    }
}

/// How progress is shown, in the words of Compose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Progress {
    /// Bars on a terminal, lines elsewhere
    Auto,
    /// Bars
    Tty,
    /// One line for each finished cell
    Plain,
    /// Nothing but the table
    Quiet,
}

impl Progress {
    /// Whether to draw bars. A CI's log is not a terminal, even if it claims to be one.
    pub(crate) fn draws(self) -> bool {
        match self {
            Progress::Auto => std::io::stderr().is_terminal() && std::env::var_os("CI").is_none(),
            Progress::Tty => true,
            Progress::Plain | Progress::Quiet => false,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct RunCell {
    /// A plan, as `run` leaves it in its results folder
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: PathBuf,
    /// The cell's index, or several: 0,3,4; default: SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX
    #[arg(long, value_name = "I", value_delimiter = ',')]
    pub(crate) index: Vec<usize>,
    /// Results folder; the cell goes into its `cells` folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Where the cell runs; not compose
    #[arg(long, value_enum, default_value_t = Backend::Netns, value_name = "WHERE")]
    pub(crate) backend: Backend,
    /// What plays the link
    #[arg(long, value_enum, default_value_t = Player::Auto, value_name = "WHO")]
    pub(crate) player: Player,
    /// Keep this machine's processors from halting during the runs, for the least lateness: needs root, uses
    /// energy, and may cost pauses on a rented machine; `doctor` measures whether it pays
    #[arg(long)]
    pub(crate) awake: bool,
    /// With --backend sim, use the timings in this file from `calibrate` instead of the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) timing: Option<PathBuf>,
    /// Maximum number of tries for a cell that is disturbed; each try is kept
    #[arg(long, value_name = "N", default_value_t = Run::TRIES, value_parser = clap::value_parser!(u8).range(1..))]
    pub(crate) tries: u8,
    /// How many cells run at the same time, with this one, for the manifest
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) together: u16,
    /// Do not open the link before this instant (monotonic clock, ns): the other cells of its batch are ready then
    #[arg(long, default_value_t = 0, value_name = "NS")]
    pub(crate) not_before_ns: u64,
}

#[derive(Debug, Args)]
pub(crate) struct Gc {
    /// Say what would be removed, and remove nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Also remove running projects started by hand, but never those of a running webloop
    #[arg(long)]
    pub(crate) force: bool,
    /// Look at this Compose project only
    #[arg(long, value_name = "NAME")]
    pub(crate) project: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct Calibrate {
    /// The results folder of a finished experiment `calibrate` (default: run it now)
    pub(crate) folder: Option<PathBuf>,
    /// File to write the timings to, for `run --backend sim --timing FILE`
    #[arg(long, value_name = "FILE", default_value = "timings.toml")]
    pub(crate) out: PathBuf,
}
