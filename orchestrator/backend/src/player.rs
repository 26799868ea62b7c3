//! What plays a link on real packets.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A player, as it is asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Player {
    /// `tc` between containers where the kernel has netem, else `user`.
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

impl std::fmt::Display for Player {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Player::Auto => "auto",
            Player::User => "user",
            Player::Tc => "tc",
        })
    }
}
