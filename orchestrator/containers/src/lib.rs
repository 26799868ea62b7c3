//! Containers, from both sides: a campaign's, driven by Docker Compose from outside, and the agents inside them.
//!
//! * [`serve()`]: the agent, an HTTP server that starts roles, reports their state and serves their
//!   files. It obeys only the first orchestrator that claims it, and ends if it has none.
//! * [`Remote`]: the orchestrator's side of one agent; [`RemoteRun`] is a run there, and
//!   [`Follower`] copies its files as they grow. [`health`] checks an agent once.
//! * [`compose`]: a campaign's containers and networks, and what killed campaigns left.
//!
//! The caller decides what the roles do, and when. Nothing here is encrypted: an agent listens on a
//! network that only its orchestrator shares.

mod agent;
pub mod compose;
mod error;
mod exchange;
mod follower;
mod name;
mod remote;
mod token;
mod wire;

pub use agent::config::{Config, Ended};
pub use agent::serve::serve;
pub use error::Error;
pub use follower::Follower;
pub use name::{AgentName, BadName, Name};
pub use remote::{Remote, RemoteRun, health};
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
    again::<Vec<process::Stop>>(bytes);
    again::<wire::Started>(bytes);
    again::<wire::RoleState>(bytes);
}
