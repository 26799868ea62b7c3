//! Starts webloop's roles as processes: on this machine, or for an orchestrator over HTTP.
//!
//! * [`Role`] and [`spawn`]: a role as a child process that cannot outlive its parent. [`Seen`] is
//!   what it looked like from outside: stopped, running, waiting for a processor.
//! * [`program`]: a controller of somebody's own, supervised; [`plant`]: a plant of somebody's own, stepped;
//!   [`first`] is the first process of their PID namespace, and [`Hidden`] what they do not see.
//! * [`serve()`]: the agent, an HTTP server that starts roles, reports their state and serves their
//!   files. It obeys only the first orchestrator that claims it, and ends if it has none.
//! * [`Remote`]: the orchestrator's side of one agent; [`RemoteRun`] is a run there, and
//!   [`Follower`] copies its files as they grow. [`health`] checks an agent once.
//!
//! The caller decides what the roles do, and when. Nothing here is encrypted: an agent listens on a
//! network that only its orchestrator shares.

mod agent;
mod answer;
mod catalogue;
mod claim;
mod config;
mod error;
mod exchange;
mod exit;
pub mod first;
mod follower;
mod freezer;
mod keeper;
mod look;
mod lookout;
mod name;
pub mod plant;
pub mod program;
mod refusal;
mod remote;
mod role;
mod route;
mod run;
mod seat;
mod serve;
mod server;
mod shelf;
mod shelter;
pub mod spawn;
mod token;
mod wire;

pub use config::{Config, Ended};
pub use error::Error;
pub use exit::UNSUPPORTED;
pub use follower::Follower;
pub use freezer::Stop;
pub use look::{Strain, busy_ns, own_strain, stolen_ns};
pub use lookout::Seen;
pub use name::{AgentName, BadName, Name};
pub use remote::{Remote, RemoteRun, health};
pub use role::{Launch, Role, last_words};
pub use serve::serve;
pub use shelter::Hidden;
pub use token::{BadToken, Token};
pub use wire::{Health, ProblemKind, RoleState};

/// Reads bytes as each thing that goes between orchestrator and agent; what is read must be written as the same.
#[cfg(fuzzing)]
pub fn fuzz(bytes: &[u8]) {
    fn again<T: serde::de::DeserializeOwned + serde::Serialize + PartialEq + std::fmt::Debug>(
        bytes: &[u8],
    ) {
        if let Ok(value) = serde_json::from_slice::<T>(bytes) {
            let text = serde_json::to_vec(&value).expect("it was read");
            assert_eq!(serde_json::from_slice::<T>(&text).ok(), Some(value));
        }
    }
    again::<wire::Health>(bytes);
    again::<wire::StartRole>(bytes);
    again::<Vec<Stop>>(bytes);
    again::<wire::Started>(bytes);
    again::<wire::RoleState>(bytes);
}
