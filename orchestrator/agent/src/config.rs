//! Settings of an agent, and why it ended.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use crate::{AgentName, Token};

/// Settings of an agent.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where it listens; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Name of the agent.
    pub name: AgentName,
    /// Where the folders of its runs are, in a folder of its own that goes when it ends.
    pub scratch: PathBuf,
    /// Its token; without one, the first that claims it gives it.
    pub token: Option<Token>,
    /// How long it waits to be claimed.
    pub unclaimed: Duration,
    /// How long it waits to hear from who claimed it.
    pub silence: Duration,
    /// What it starts as `PROGRAM serve ROLE ...`: webloop itself.
    pub program: PathBuf,
}

impl Config {
    /// For [`Config::unclaimed`]: images start within seconds, a person at a keyboard within this.
    pub const UNCLAIMED: Duration = Duration::from_secs(60);

    /// For [`Config::silence`]: longer than any pause of an orchestrator that lives.
    pub const SILENCE: Duration = Duration::from_secs(30);
}

/// Why an agent ended in good order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It got SIGTERM or SIGINT.
    Signalled,
    /// Its orchestrator asked for it.
    Asked,
    /// No orchestrator claimed it within this time.
    Unclaimed(Duration),
    /// Its orchestrator was not heard for this time.
    Silent(Duration),
}

impl Ended {
    /// Whether it was left alone, which its log should say.
    #[must_use]
    pub fn orphaned(self) -> bool {
        matches!(self, Ended::Unclaimed(_) | Ended::Silent(_))
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ended::Signalled => write!(formatter, "stopped by a signal"),
            Ended::Asked => write!(formatter, "stopped by its orchestrator"),
            Ended::Unclaimed(after) => {
                write!(
                    formatter,
                    "ends, because no orchestrator claimed it within {after:?}"
                )
            }
            Ended::Silent(after) => {
                write!(
                    formatter,
                    "ends, because its orchestrator was silent for {after:?}"
                )
            }
        }
    }
}
