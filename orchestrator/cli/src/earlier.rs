//! What earlier runs left in a folder that is gone on with: taken for this run's own only where this
//! run would have made it alike.
//!
//! Whether it is whole is `analysis`' to say.

use std::path::Path;

use anyhow::anyhow;
use plan::{Manifest, Plan};

use crate::argument::{Backend, Player};
use crate::exit::Failure;
use crate::jobs::{Conditions, word};

/// How this run makes its cells.
pub(crate) struct Own {
    /// As manifests call it.
    backend: String,
    /// Who plays the link, where that was asked for.
    player: Option<String>,
}

impl Own {
    /// Of a run on this conditions.
    pub(crate) fn of(conditions: &Conditions<'_>) -> Own {
        let agents = conditions.agents.map(|agents| agents.backend.as_str());
        Own::new(conditions.backend, agents, conditions.player)
    }

    /// By a back-end, which agents may call by a name of its own.
    pub(crate) fn new(backend: Backend, agents: Option<&str>, player: Player) -> Own {
        let is_asked = player != Player::Auto && backend != Backend::Sim;
        Own {
            backend: agents.map_or_else(|| word(&backend), str::to_owned),
            player: is_asked.then(|| word(&player)),
        }
    }

    /// Whether an earlier run of the plan in `folder` is as this one would make it.
    ///
    /// # Errors
    /// Where it was another back-end, player, version or seed; exit code 2.
    pub(crate) fn check(
        &self,
        plan: &Plan,
        earlier: &Manifest,
        folder: &Path,
    ) -> Result<(), Failure> {
        let version = env!("CARGO_PKG_VERSION");
        let seeds = [earlier.campaign_seed, plan.seed].map(|seed| seed.to_string());
        let pairs = [
            ("back-end", &*earlier.backend, &*self.backend),
            ("version of webloop", &earlier.webloop, version),
            ("campaign's seed", &seeds[0], &seeds[1]),
        ];
        let other = pairs.into_iter().find(|(_, earlier, own)| earlier != own);
        // Over loopback nobody plays, whoever was asked to.
        let player = self.player.as_deref().filter(|_| earlier.player != "none");
        let player = player.map(|own| ("player", &*earlier.player, own));
        match other.or(player.filter(|(_, earlier, own)| earlier != own)) {
            None => Ok(()),
            Some((what, earlier, own)) => Err(Failure::usage(anyhow!(
                "{}: this run's {what} is {earlier}, and now {own} is asked for; one folder holds \
                 runs of one kind, so choose another with --out",
                folder.join(Manifest::FILE).display()
            ))),
        }
    }
}
