//! A link as it is played: its two directions under one seed.

use crate::path::Path;
use crate::profile::Profile;
use crate::way::Way;

/// Both directions of a link as it is played.
#[derive(Debug, Clone)]
pub struct Link {
    /// From controller to plant.
    pub up: Path,
    /// From plant to controller.
    pub down: Path,
}

impl Link {
    /// The two paths of a link. Equal seeds give equal states at every instant, on every machine. The two
    /// directions draw independently, but for where their traces begin and when faults of both ways come.
    #[must_use]
    pub fn new(profile: &Profile, seed: u64) -> Link {
        Link {
            up: Path::new(profile.law(Way::Up), Way::Up, seed),
            down: Path::new(profile.law(Way::Down), Way::Down, seed),
        }
    }

    /// The same link, whose traces begin at this share of their span instead of where the seed says.
    pub(crate) fn begun_at(profile: &Profile, seed: u64, share: f64) -> Link {
        let path = |way| Path::begun(profile.law(way).begun_at(share), way, seed);
        Link {
            up: path(Way::Up),
            down: path(Way::Down),
        }
    }

    /// One direction.
    #[must_use]
    pub fn path(&self, way: Way) -> &Path {
        match way {
            Way::Up => &self.up,
            Way::Down => &self.down,
        }
    }

    /// One direction, mutable, to play it.
    #[inline]
    pub fn path_mut(&mut self, way: Way) -> &mut Path {
        match way {
            Way::Up => &mut self.up,
            Way::Down => &mut self.down,
        }
    }
}
