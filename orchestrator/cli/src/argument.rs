//! The command line: what can be typed, and its help.
//!
//! Nothing is looked up here, and nothing is checked beyond what the types' own parsers check.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

mod again;
mod attempt;
mod campaign;
mod conform;
mod field;
mod help;
mod link;
mod margin;
mod matrix;
mod report;
mod results;
mod serve;
mod system;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue};
use clap::{FromArgMatches, Parser, Subcommand, ValueEnum};

pub(crate) use attempt::Try;
pub(crate) use campaign::{
    Allowed, Backend, Calibrate, Choice, Gate, Gc, Player, Progress, Run, RunCell, UNDECIDED,
    Undecided, word,
};
pub(crate) use conform::Conform;
pub(crate) use help::command;
pub(crate) use link::{LinkCommand, LinkLint, LinkShow, Probe, Way};
pub(crate) use margin::Margin;
pub(crate) use matrix::{Document, Matrix, MatrixFormat};
pub(crate) use report::{Publication, Report};
pub(crate) use results::{Agree, AgreeFormat, Collect, Compare, CompareFormat, Show, ShowFormat};
pub(crate) use serve::{
    ServeAgent, ServeBrowser, ServeCommand, ServeController, ServeFirst, ServeHalf, ServeHealth,
    ServeLink, ServePlant, ServeProgram,
};
pub(crate) use system::{SystemCommand, SystemLint, SystemShow};

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
    /// Format of log lines on standard error; RUST_LOG chooses which are shown (default: warn)
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, value_name = "FORMAT", hide_possible_values = true, help_heading = "Logging")]
    pub(crate) log_format: LogFormat,
    /// Run as the user that owns this folder; used in containers
    #[arg(long, value_name = "DIR", hide = true)]
    pub(crate) become_owner_of: Option<PathBuf>,
}

impl Argument {
    /// Parses the command line. Prints help or a usage error, and ends the program, if necessary.
    pub(crate) fn read() -> Argument {
        let read = help::command().try_get_matches();
        let read = read.and_then(|matches| Argument::from_arg_matches(&matches));
        read.unwrap_or_else(|mut error| {
            offer(&mut error);
            // It quotes the command line, in colours of its own.
            let said = error.render().to_string();
            if error.use_stderr() && said.contains(text::is_active) {
                say!("{}", said.trim_end());
                std::process::exit(error.exit_code());
            }
            error.exit()
        })
    }

    /// The arguments of `webloop run EXPERIMENT --out FOLDER`.
    pub(crate) fn of_run(experiment: &str, folder: &Path) -> Argument {
        let words = ["webloop", "run", experiment, "--out"].map(OsStr::new);
        Argument::parse_from(words.into_iter().chain([folder.as_os_str()]))
    }
}

/// Offers the command that was meant, where clap has none to offer.
fn offer(error: &mut clap::Error) {
    let (meant, given) = (
        ContextKind::SuggestedSubcommand,
        ContextKind::InvalidSubcommand,
    );
    if error.get(meant).is_some() {
        return;
    }
    let Some(ContextValue::String(given)) = error.get(given) else {
        return;
    };
    let all = help::command();
    let shown = all.get_subcommands().filter(|one| !one.is_hide_set());
    let name = text::nearest(given, shown.map(clap::Command::get_name));
    if let Some(name) = name.map(str::to_owned) {
        error.insert(meant, ContextValue::Strings(vec![name]));
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
    /// Your own controller, plant or system over a link, in one line
    Try(Try),
    /// Run an experiment and print its table, or the findings and maps of a sweep
    Run(Run),
    /// Fail unless an experiment shows what it expects, in virtual time and then for real
    Gate(Gate),
    /// Run one cell of a plan, unless it is already complete
    RunCell(RunCell),
    /// Print the table of a results folder again
    Show(Show),
    /// Make the report on a results folder: one page to open
    Report(Report),
    /// Compare two results folders: is the second worse?
    Compare(Compare),
    /// Does a results folder in virtual time agree with one over real sockets?
    Agree(Agree),
    /// Measure how long programs take for a message on this machine, for --backend sim
    Calibrate(Calibrate),
    /// Split an experiment into jobs, for CI
    Matrix(Matrix),
    /// Merge results folders of one plan, such as those of jobs, into one
    Collect(Collect),
    /// How much delay a loop survives, and how often a link stays within it
    Margin(Margin),
    /// Run a sweep; `run` does it now
    #[command(hide = true)]
    Sweep(Run),
    /// List, show and check systems: plants with their control laws
    #[command(subcommand)]
    System(SystemCommand),
    /// Explain and check link profiles
    #[command(subcommand)]
    Link(LinkCommand),
    /// Ping through a topology's link and compare with what the link should do
    Probe(Probe),
    /// Test whether a controller or a plant of your own keeps its contract
    Conform(Conform),
    /// Say what this machine can do, what is missing, and what to do about it
    Doctor,
    /// Remove the containers and networks that killed runs left, and nothing else
    Gc(Gc),
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

/// A time above zero and up to a week, ns.
fn time(text: &str) -> anyhow::Result<u64> {
    let time_ns = text::duration_ns(text, 1..=text::WEEK_NS);
    time_ns.map_err(|invalid| anyhow::anyhow!("{invalid}; {}", invalid.remedy))
}
