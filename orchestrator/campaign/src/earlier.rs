//! What earlier runs left in a folder that is gone on with: taken for this run's own only where this
//! run would have made it alike.
//!
//! Whether it is whole is `analysis`' to say.

use std::path::Path;

use manifest::Manifest;
use plan::Plan;

use crate::error::Error;

/// How this run makes its cells.
#[derive(Debug)]
pub struct Own {
    /// As manifests call it.
    pub backend: String,
    /// Who plays the link, where that was asked for.
    pub player: Option<String>,
}

impl Own {
    /// Whether an earlier run of the plan in `folder` is as this one would make it.
    ///
    /// # Errors
    /// [`Error::OtherKind`] where it was another back-end, player, version or seed.
    pub fn check(&self, plan: &Plan, earlier: &Manifest, folder: &Path) -> Result<(), Error> {
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
            Some((what, earlier, own)) => Err(Error::OtherKind {
                manifest: folder.join(Manifest::FILE),
                what,
                earlier: earlier.to_owned(),
                own: own.to_owned(),
            }),
        }
    }
}
