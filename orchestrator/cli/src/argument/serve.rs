//! Arguments of roles that are started by hand, by an agent or by a run.

// The comments on arguments are their help, printed as they stand.
#![allow(clippy::doc_markdown)]

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, bail};
use browser::Engine;
use clap::{Args, Subcommand};
use containers::AgentName;
use endpoint::{ControllerSettings, Mode, PageSettings, PlantSettings, Policy, SampleTime};

use super::field::Fields;
use super::{Player, Way, time};

#[derive(Debug, Subcommand)]
pub(crate) enum ServeCommand {
    /// The plant: free-runs every h, and answers over HTTP
    Plant(ServePlant),
    /// The controller: sends every h, and ends after its duration
    Controller(ServeController),
    /// The controller in Python, with the same options
    Python(ServeController),
    /// The controller as a page in a real browser, which it starts and watches
    Browser(ServeBrowser),
    /// A controller of your own: starts it confined, and ends it when its time is over
    Program(ServeProgram),
    /// The first process beside such a program
    #[command(hide = true)]
    First(ServeFirst),
    /// The link: plays its profile between two interfaces, or one direction of it beside an end
    Link(ServeLink),
    /// One half of a probe: sends echoes beside the controller
    #[command(hide = true)]
    Ask(ServeHalf),
    /// The other half of a probe: records the echoes that reach the plant
    #[command(hide = true)]
    Hear(ServeHalf),
    /// An agent: starts the other roles for an orchestrator on another machine or container
    Agent(ServeAgent),
    /// Exit with 0 if an agent answers: for containers' health checks
    Health(ServeHealth),
}

#[derive(Debug, Args)]
pub(crate) struct ServePlant {
    #[command(flatten)]
    pub(crate) told: Told,
    /// Address to listen on
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub(crate) listen: SocketAddr,
    /// A name under which clients know it, besides addresses, localhost and this machine's name; repeatable
    #[arg(long = "host", value_name = "NAME", value_parser = host)]
    pub(crate) hosts: Vec<String>,
    /// Sample time
    #[arg(long, default_value = "3ms", value_name = "TIME")]
    pub(crate) h: SampleTime,
    #[command(flatten)]
    pub(crate) settings: Fields<PlantSettings>,
    /// The seed of these delays, and of what is random in a program that is the plant
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub(crate) noise_seed: u64,
    /// The system to control: a built-in one, or the path of a system file
    #[arg(long, default_value = "motor")]
    pub(crate) system: String,
    /// Where ticks.csv, arrivals.csv and plant.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

/// What every role can be told at once.
#[derive(Debug, Args)]
pub(crate) struct Told {
    /// Everything but --out as one JSON value, in place of the other options; - is standard input
    #[arg(long = "settings", value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct ServeController {
    #[command(flatten)]
    pub(crate) told: Told,
    /// The plant
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
    pub(crate) plant: SocketAddr,
    /// Sample time
    #[arg(long, default_value = "3ms", value_name = "TIME")]
    pub(crate) h: SampleTime,
    /// open or closed
    #[arg(long, default_value = "closed")]
    pub(crate) mode: Mode,
    /// Reference (default: the system's)
    #[arg(long, value_parser = reference, allow_negative_numbers = true)]
    pub(crate) r: Option<f64>,
    /// How long to send
    #[arg(long = "duration", default_value = "6s", value_name = "TIME", value_parser = time)]
    pub(crate) duration_ns: u64,
    #[command(flatten)]
    pub(crate) settings: Fields<ControllerSettings>,
    /// Claim the plant for a session, as its lease "token" asks; a page always does
    #[arg(long)]
    pub(crate) claim: bool,
    /// End each command with its checksum, and take only answers with theirs; the native controller only
    #[arg(long)]
    pub(crate) check: bool,
    /// What its thread asks the kernel for: fifo (real time) or other (as a desktop's programs); the native controller
    /// only
    #[arg(long, default_value = "fifo", value_name = "POLICY")]
    pub(crate) scheduling: Policy,
    /// The system whose law to use: a built-in one, or the path of a system file; a page uses the plant's
    #[arg(long, default_value = "motor")]
    pub(crate) system: String,
    /// When to send the first message, in ns of CLOCK_MONOTONIC (default: soon)
    #[arg(long, value_name = "T")]
    pub(crate) start_ns: Option<u64>,
    /// Where messages.csv and controller.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ServeBrowser {
    /// chromium or firefox
    #[arg(long, default_value = "chromium")]
    pub(crate) engine: Engine,
    #[command(flatten)]
    pub(crate) controller: ServeController,
    #[command(flatten)]
    pub(crate) page: Fields<PageSettings>,
}

#[derive(Debug, Args)]
pub(crate) struct ServeProgram {
    #[command(flatten)]
    pub(crate) controller: ServeController,
    /// The program and its arguments
    #[arg(last = true, value_name = "COMMAND")]
    pub(crate) run: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ServeFirst {
    /// Do not start it before this instant (monotonic clock, ns)
    #[arg(long, default_value_t = 0, value_name = "NS")]
    pub(crate) not_before_ns: u64,
    /// The program and its arguments
    #[arg(last = true, value_name = "COMMAND")]
    pub(crate) run: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ServeLink {
    #[command(flatten)]
    pub(crate) told: Told,
    /// A built-in topology, or the path of a profile file
    #[arg(long, required_unless_present = "file")]
    pub(crate) profile: Option<String>,
    /// The link's seed
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Link time 0, in ns of CLOCK_MONOTONIC; the link is empty before (default: now)
    #[arg(long, value_name = "T")]
    pub(crate) epoch_ns: Option<u64>,
    /// Interface towards the controller, when both directions are played
    #[arg(long, default_value = "controller", value_name = "NAME")]
    pub(crate) controller: String,
    /// Interface towards the plant, when both directions are played
    #[arg(long, default_value = "plant", value_name = "NAME")]
    pub(crate) plant: String,
    /// Play one direction only, beside the end that sends in it
    #[arg(long, value_enum, value_name = "WAY")]
    pub(crate) way: Option<Way>,
    /// What plays that direction
    #[arg(long, value_enum, default_value_t = Player::Auto, value_name = "WHO")]
    pub(crate) player: Player,
    /// Host name or address of this end on the network of the link
    #[arg(long, env = "WEBLOOP_LOCAL", value_name = "HOST")]
    pub(crate) local: Option<String>,
    /// Host name or address of the other end on that network
    #[arg(long, env = "WEBLOOP_PEER", value_name = "HOST")]
    pub(crate) peer: Option<String>,
    /// Interface that tc shapes (default: the one towards the peer)
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// Where link.csv and link.json go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

/// A half of a probe: it is told all of it at once, by an agent.
#[derive(Debug, Args)]
pub(crate) struct ServeHalf {
    /// JSON file of the echoes to send or expect; - is standard input
    #[arg(long, value_name = "FILE")]
    pub(crate) settings: PathBuf,
    /// Where its rows go
    #[arg(long, value_name = "DIR", default_value = "serve")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ServeAgent {
    /// plant, controller, plant-link or controller-link
    pub(crate) name: AgentName,
    /// Address to listen on, in the orchestrator's network only; a name is resolved at the start
    #[arg(long, default_value = "127.0.0.1:7070", value_name = "ADDRESS:PORT")]
    pub(crate) listen: String,
    /// Folder for a run's rows until the orchestrator has copied them
    #[arg(long, value_name = "DIR")]
    pub(crate) scratch: PathBuf,
    /// End if no orchestrator claims the agent within this time; a slow machine needs more
    #[arg(
        long = "patience",
        env = "WEBLOOP_PATIENCE",
        default_value = "60s",
        value_name = "TIME",
        value_parser = time
    )]
    pub(crate) patience_ns: u64,
}

#[derive(Debug, Args)]
pub(crate) struct ServeHealth {
    /// The agent
    #[arg(long, default_value = "127.0.0.1:7070", value_name = "ADDRESS:PORT")]
    pub(crate) agent: String,
    /// Do not exit while the agent works, so that a container engine asks only once
    #[arg(long)]
    pub(crate) hold: bool,
}

fn host(text: &str) -> anyhow::Result<String> {
    endpoint::host::is_name(text)
        .then(|| text.to_owned())
        .context("give a host's name, like plant or bench.lab, without a port")
}

fn reference(text: &str) -> anyhow::Result<f64> {
    match text.parse::<f64>() {
        Ok(r) if r.is_finite() => Ok(r),
        _ => bail!("give a finite number, like 1 or -0.5"),
    }
}
