//! The command line: what can be typed, and its help.
//!
//! Nothing is looked up or checked here beyond what a type's own reading checks.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use endpoint::{Connection, Integrate, Late, Mode, Outstanding, SampleTime, Schedule};
use jiff::SignedDuration;

/// Closes control loops over real HTTP, across links that behave like real networks, and says
/// whether the loop survives.
#[derive(Debug, Parser)]
#[command(
    name = "webloop",
    version,
    propagate_version = true,
    max_term_width = 100
)]
#[command(
    after_help = "Start with: webloop run\n\nExit codes: 0 fine, 1 a run failed or did not hold, 2 wrong usage or file, \
3 this machine lacks something, 130 interrupted."
)]
pub(crate) struct Argument {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// How log lines on standard error look; RUST_LOG chooses which (default: warn)
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, value_name = "FORMAT", hide_possible_values = true, help_heading = "Logging")]
    pub(crate) log_format: LogFormat,
}

impl Argument {
    /// Reads the command line; prints help or a usage error and ends the program where it has to.
    pub(crate) fn read() -> Argument {
        Argument::parse()
    }
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run an experiment and print its table
    Run(Run),
    /// Run one cell of a plan; does nothing where it is already complete
    RunCell(RunCell),
    /// Print the table of a results folder again
    Show(Show),
    /// Explain and check link profiles
    #[command(subcommand)]
    Link(LinkCommand),
    /// Ping through a topology's link and compare with what the link should do
    Probe(Probe),
    /// Say what this machine can do, what is missing, and what to do about it
    Doctor,
    /// Run one role by hand
    #[command(subcommand)]
    Serve(ServeCommand),
    /// Print shell completions
    #[command(hide = true)]
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Write manual pages
    #[command(hide = true)]
    Man {
        /// Where to
        folder: PathBuf,
    },
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    /// smoke, settling, paper, or the path of an experiment file
    #[arg(default_value = "smoke")]
    pub(crate) experiment: String,
    /// Run only cells whose id contains PATTERN, or is spelled by it with * (repeatable)
    #[arg(long, value_name = "PATTERN")]
    pub(crate) only: Vec<String>,
    /// Cells run at a time; more than one shares the processors and shows in the timing
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    pub(crate) jobs: u16,
    /// The campaign's seed; equal seeds give equal links
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Print the cells and how long they will take, and run nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Results folder; a folder with the same plan is continued
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// How progress is shown
    #[arg(long, value_enum, default_value_t = Progress::Auto, value_name = "HOW")]
    pub(crate) progress: Progress,
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

#[derive(Debug, Args)]
pub(crate) struct RunCell {
    /// A plan, as `run` leaves it in its results folder
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: PathBuf,
    /// The cell's index; SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX where it is not given
    #[arg(long, value_name = "I")]
    pub(crate) index: Option<usize>,
    /// Results folder; the cell goes into its `cells` folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Show {
    /// A results folder
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Subcommand)]
pub(crate) enum LinkCommand {
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
    /// Print only the summary
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

fn interval(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.001..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err("give seconds between 0.001 and 3600".to_owned()),
    }
}

fn reference(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(r) if r.is_finite() => Ok(r),
        _ => Err("give a finite number, like 1 or -0.5".to_owned()),
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum ServeCommand {
    /// The plant: free-runs every h, and answers over HTTP
    Plant(ServePlant),
    /// The controller: sends every h, and ends after its duration
    Controller(ServeController),
    /// The link: forwards between two interfaces as its profile says
    Link(ServeLink),
}

#[derive(Debug, Args)]
pub(crate) struct ServePlant {
    /// Address to listen on
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub(crate) listen: SocketAddr,
    /// Sample time
    #[arg(long, default_value = "3ms", value_name = "TIME")]
    pub(crate) h: SampleTime,
    /// Commands that a newer one has overtaken: apply or drop
    #[arg(long, default_value = "apply")]
    pub(crate) late: Late,
    /// Where ticks.csv, arrivals.csv and plant.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ServeController {
    /// The plant
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub(crate) plant: SocketAddr,
    /// Sample time
    #[arg(long, default_value = "3ms", value_name = "TIME")]
    pub(crate) h: SampleTime,
    /// open or closed
    #[arg(long, default_value = "closed")]
    pub(crate) mode: Mode,
    /// Reference
    #[arg(long, default_value_t = 1.0, value_parser = reference, allow_negative_numbers = true)]
    pub(crate) r: f64,
    /// How long to send
    #[arg(long, default_value = "6s", value_name = "TIME")]
    pub(crate) duration: SignedDuration,
    /// Requests under way: a number, or unlimited
    #[arg(long, default_value = "unlimited", value_name = "N")]
    pub(crate) outstanding: Outstanding,
    /// keep or new
    #[arg(long, default_value = "keep")]
    pub(crate) connection: Connection,
    /// absolute or relative
    #[arg(long, default_value = "absolute")]
    pub(crate) schedule: Schedule,
    /// h or elapsed
    #[arg(long, default_value = "h")]
    pub(crate) integrate: Integrate,
    /// Answers that a newer one has overtaken: apply or drop
    #[arg(long, default_value = "apply")]
    pub(crate) late: Late,
    /// After this a request is given up
    #[arg(long, default_value = "5s", value_name = "TIME")]
    pub(crate) timeout: SignedDuration,
    /// When to send the first message, in ns of CLOCK_MONOTONIC; soon, if not given
    #[arg(long, value_name = "T")]
    pub(crate) start_ns: Option<u64>,
    /// Where messages.csv and controller.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ServeLink {
    /// A built-in topology, or the path of a profile file
    #[arg(long)]
    pub(crate) profile: String,
    /// The link's seed
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Link time 0, in ns of CLOCK_MONOTONIC; the link is empty before it. Now, if not given
    #[arg(long, value_name = "T")]
    pub(crate) epoch_ns: Option<u64>,
    /// Interface towards the controller
    #[arg(long, default_value = "controller", value_name = "NAME")]
    pub(crate) controller: String,
    /// Interface towards the plant
    #[arg(long, default_value = "plant", value_name = "NAME")]
    pub(crate) plant: String,
    /// Where link.csv and link.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}
