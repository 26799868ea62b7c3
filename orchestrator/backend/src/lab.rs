//! The network of one run: two ends, each in its own namespace, and the place of the link between them.
//!
//! ```text
//!   controller              middle                 plant
//!   10.77.0.1  link0 ═══ controller  plant ═══ link0  10.77.0.2
//! ```
//!
//! On a loopback topology both ends share one namespace and there is no middle.

use std::net::Ipv4Addr;

use link::Profile;
use shaper::Namespace;

use crate::player::Player;

/// Namespaces and addresses. They disappear with this value and the processes in them.
pub struct Lab {
    controller: Namespace,
    /// `None` where the plant shares the controller's namespace.
    shaped: Option<Shaped>,
}

struct Shaped {
    plant: Namespace,
    middle: Namespace,
}

impl Lab {
    /// Makes the network that `profile` needs, for this player.
    ///
    /// # Errors
    /// The shaper's: what this machine does not allow, with the remedy.
    pub fn new(profile: &Profile, player: Player) -> shaper::Result<Lab> {
        let controller = Namespace::new()?;
        if profile.is_loopback() {
            return Ok(Lab {
                controller,
                shaped: None,
            });
        }
        let (plant, middle) = (Namespace::new()?, Namespace::new()?);
        // netem takes what it gets for one packet.
        let in_segments = profile.treats_packets_alike() && player != Player::Tc;
        shaper::join(&controller, &plant, &middle, in_segments)?;
        Ok(Lab {
            controller,
            shaped: Some(Shaped { plant, middle }),
        })
    }

    /// Where the controller runs.
    #[must_use]
    pub fn controller(&self) -> &Namespace {
        &self.controller
    }

    /// Where the plant runs.
    #[must_use]
    pub fn plant(&self) -> &Namespace {
        self.shaped
            .as_ref()
            .map_or(&self.controller, |shaped| &shaped.plant)
    }

    /// Where the link is played, if there is one.
    #[must_use]
    pub fn middle(&self) -> Option<&Namespace> {
        self.shaped.as_ref().map(|shaped| &shaped.middle)
    }

    /// The plant's address, as the controller sees it.
    #[must_use]
    pub fn plant_address(&self) -> Ipv4Addr {
        match self.shaped {
            Some(_) => shaper::PLANT_ADDRESS,
            None => Ipv4Addr::LOCALHOST,
        }
    }
}
