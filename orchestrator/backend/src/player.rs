//! What plays a link on real packets.

use link::Profile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::RunError;

/// A player, as it is asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Player {
    /// `tc` between containers where the kernel has netem and it can play the link's faults, else `user`.
    ///
    /// In namespaces it is `user`, always: there it plays each packet by the model, to some
    /// tens of microseconds, where netem plays the model's state in steps.
    #[default]
    Auto,
    /// webloop itself, packet by packet.
    User,
    /// The kernel's netem, changed in time.
    Tc,
}

impl Player {
    /// Refuses a link with a fault that the player cannot play: tc delays and loses packets, but it does
    /// not know which to change.
    ///
    /// # Errors
    /// [`RunError::Unsupported`], with the fault and the remedy.
    pub fn check(self, profile: &Profile) -> Result<(), RunError> {
        match (self, profile.beyond_tc()) {
            (Player::Tc, Some(fault)) => Err(RunError::Unsupported(format!(
                "tc cannot play the fault `{fault}` of the link `{}`: use --player user",
                profile.name()
            ))),
            _ => Ok(()),
        }
    }
}

impl std::fmt::Display for Player {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Player::Auto => "auto",
            Player::User => "user",
            Player::Tc => "tc",
        })
    }
}
