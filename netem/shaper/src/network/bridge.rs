//! A middle whose kernel forwards: a Linux bridge between the interfaces that lead to the two ends,
//! for a link that tc plays on the way out of each.
//!
//! ```text
//!  controller ──── controller  bridge  plant ──── plant
//!                  down ▲                ▲ up
//! ```

use crate::error::Result;
use crate::network::netlink::Netlink;
use crate::network::veth::{CONTROLLER_INTERFACE, PLANT_INTERFACE};

/// The bridge's own interface.
const BRIDGE_INTERFACE: &str = "bridge";

/// Lets the kernel of the calling thread's namespace, which [`join`](crate::join) has made the
/// middle, forward between the two ends. Then play `up` on [`PLANT_INTERFACE`] and `down` on
/// [`CONTROLLER_INTERFACE`], and do not use [`play`](crate::play).
///
/// # Errors
/// [`Error::Unsupported`](crate::Error::Unsupported) on a kernel without bridges,
/// [`Error::Failed`](crate::Error::Failed) if the kernel rejects a step.
pub fn bridge() -> Result<()> {
    let mut netlink = Netlink::open()?;
    netlink.create_bridge(BRIDGE_INTERFACE)?;
    let bridge = netlink.index_of(BRIDGE_INTERFACE)?;
    for port in [CONTROLLER_INTERFACE, PLANT_INTERFACE] {
        let port = netlink.index_of(port)?;
        netlink.enslave(port, bridge)?;
    }
    netlink.bring_up(bridge)
}
