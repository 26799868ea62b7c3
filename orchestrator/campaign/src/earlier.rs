//! Checks earlier runs in a folder that is continued. They count as this run's own only if this run
//! would have made them the same way.
//!
//! `analysis` checks whether they are whole.

use std::path::Path;

use plan::Plan;
use record::Manifest;

use crate::error::Error;

/// How this run makes its cells.
#[derive(Debug)]
pub struct Own {
    /// The back-end's name in manifests.
    pub backend: String,
    /// The link's player, if one was requested.
    pub player: Option<String>,
}

impl Own {
    /// Checks that an earlier run of the plan in `folder` is as this run would make it.
    ///
    /// # Errors
    /// [`Error::OtherKind`] when its back-end, player, version or seed differs.
    pub fn check(&self, plan: &Plan, earlier: &Manifest, folder: &Path) -> Result<(), Error> {
        let version = env!("CARGO_PKG_VERSION");
        let seeds = [earlier.campaign_seed, plan.seed].map(|seed| seed.to_string());
        let pairs = [
            ("back-end", &*earlier.backend, &*self.backend),
            ("version of webloop", &earlier.webloop, version),
            ("campaign's seed", &seeds[0], &seeds[1]),
        ];
        let other = pairs.into_iter().find(|(_, earlier, own)| earlier != own);
        // Loopback has no player, whatever was requested.
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
