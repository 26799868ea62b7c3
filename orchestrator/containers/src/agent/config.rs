//! Settings of an agent, and why it ended.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use crate::name::AgentName;
use crate::token::Token;

/// Settings of an agent.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where it listens; port 0 takes a free one.
    pub listen: SocketAddr,
    /// The names under which clients know it, besides addresses, `localhost` and the name of the machine.
    pub hosts: Vec<String>,
    /// Name of the agent.
    pub name: AgentName,
    /// Where it makes a folder of its own for its runs; it removes that folder when it ends.
    pub scratch: PathBuf,
    /// Its token; if there is none, the first claim sets it.
    pub token: Option<Token>,
    /// How long it waits to be claimed.
    pub unclaimed: Duration,
    /// How long it waits to hear from the orchestrator that claimed it.
    pub silence: Duration,
    /// The program that it starts as `PROGRAM serve ROLE ...`: webloop itself.
    pub program: PathBuf,
}

impl Config {
    /// For [`Config::unclaimed`]: images start within seconds, a person needs up to a minute.
    pub const UNCLAIMED: Duration = Duration::from_secs(60);

    /// For [`Config::silence`]: longer than any pause of a live orchestrator.
    pub const SILENCE: Duration = Duration::from_secs(30);
}

/// Why an agent ended in good order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It got SIGTERM or SIGINT.
    Signalled,
    /// Its orchestrator told it to end.
    Asked,
    /// No orchestrator claimed it within this time.
    Unclaimed(Duration),
    /// Its orchestrator was silent for this time.
    Silent(Duration),
}

impl Ended {
    /// Whether it ended for lack of an orchestrator, which its log should say.
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
