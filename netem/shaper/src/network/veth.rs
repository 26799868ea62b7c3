//! The cables of a cell: `controller` and `plant` in the middle, each tied to the only
//! interface of its end.
//!
//! ```text
//!  controller's namespace        the middle         plant's namespace
//!   link0 10.77.0.1/30 ──── controller   plant ──── link0 10.77.0.2/30
//! ```
//!
//! The middle has no address and its kernel forwards nothing, so packets cross only through the
//! [player](crate::player). The two ends are neighbours on one subnet and know each other's Ethernet
//! address in advance, so that no ARP is ever shaped.
//!
//! Ends that are joined by a [tunnel](crate::player::tunnel) get another kind of cable, which
//! represents the network that the tunnel crosses.

use std::net::{Ipv4Addr, UdpSocket};
use std::os::fd::AsFd;

use crate::error::{Doing, Result};
use crate::network::namespace::Namespace;
use crate::network::netlink::{End, Mac, Netlink};
use crate::port::tells_offload;
use crate::sys;

/// The controller's address on the link.
pub const CONTROLLER_ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 1);
/// The plant's address on the link.
pub const PLANT_ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 2);
/// The prefix length of their subnet.
pub(crate) const PREFIX_LEN: u8 = 30;

/// The only interface of an end besides loopback.
pub const END_INTERFACE: &str = "link0";
/// The interface in the middle that leads to the controller.
pub const CONTROLLER_INTERFACE: &str = "controller";
/// The interface in the middle that leads to the plant.
pub const PLANT_INTERFACE: &str = "plant";

/// The interface from an end to the network that a tunnel crosses.
const NETWORK_INTERFACE: &str = "network0";
/// The ends' addresses on that network, the controller's first.
const NETWORK_ADDRESSES: [Ipv4Addr; 2] = [Ipv4Addr::new(10, 78, 0, 1), Ipv4Addr::new(10, 78, 0, 2)];

/// Locally administered (bit `0x02`) and fixed, so that each end knows the other's.
const CONTROLLER_MAC: Mac = [0x02, 0x77, 0, 0, 0, 1];
const PLANT_MAC: Mac = [0x02, 0x77, 0, 0, 0, 2];
const MIDDLE_CONTROLLER_MAC: Mac = [0x02, 0x77, 0, 0, 1, 1];
const MIDDLE_PLANT_MAC: Mac = [0x02, 0x77, 0, 0, 1, 2];

/// Joins the ends through the middle with two veth pairs. Each interface is created directly in its
/// namespace, so that a crash half-way leaves nothing behind.
///
/// With `in_segments`, the ends may leave cutting and checksums for later, as they would on a plain cable, if
/// this kernel tells the player what was left; otherwise each packet crosses as a wire carries it. That is for a
/// link that [treats packets alike](link::Profile::treats_packets_alike) and is [played](crate::play) here.
///
/// # Errors
/// [`Error::Unsupported`](crate::Error::Unsupported) on a kernel without veth,
/// [`Error::Failed`](crate::Error::Failed) if the kernel rejects a step.
pub fn join(
    controller: &Namespace,
    plant: &Namespace,
    middle: &Namespace,
    in_segments: bool,
) -> Result<()> {
    let offloads = if in_segments && middle.run(|| Ok(tells_offload()))? {
        &MERGING[..]
    } else {
        &OFFLOADS[..]
    };
    let end = |namespace, mac| End {
        name: END_INTERFACE,
        mac,
        namespace,
    };
    middle.run(|| {
        let mut netlink = Netlink::open()?;
        for (name, mac, far) in [
            (
                CONTROLLER_INTERFACE,
                MIDDLE_CONTROLLER_MAC,
                end(controller.as_fd(), CONTROLLER_MAC),
            ),
            (
                PLANT_INTERFACE,
                MIDDLE_PLANT_MAC,
                end(plant.as_fd(), PLANT_MAC),
            ),
        ] {
            let near = End {
                name,
                mac,
                namespace: middle.as_fd(),
            };
            netlink.create_pair(&near, &far)?;
            turn_off(offloads, name)?;
            let index = netlink.index_of(name)?;
            netlink.bring_up(index)?;
        }
        Ok(())
    })?;
    for (end, address, far) in [
        (controller, CONTROLLER_ADDRESS, (PLANT_ADDRESS, PLANT_MAC)),
        (plant, PLANT_ADDRESS, (CONTROLLER_ADDRESS, CONTROLLER_MAC)),
    ] {
        end.run(|| {
            turn_off(offloads, END_INTERFACE)?;
            configure_end(END_INTERFACE, address, far)
        })?;
    }
    Ok(())
}

/// Joins the ends by one plain cable, as a network of containers or machines does, for a tunnel to
/// cross. Returns its addresses, the controller's first.
///
/// # Errors
/// The same as [`join`].
pub fn connect(controller: &Namespace, plant: &Namespace) -> Result<[Ipv4Addr; 2]> {
    let end = |namespace, mac| End {
        name: NETWORK_INTERFACE,
        mac,
        namespace,
    };
    controller.run(|| {
        Netlink::open()?.create_pair(
            &end(controller.as_fd(), CONTROLLER_MAC),
            &end(plant.as_fd(), PLANT_MAC),
        )
    })?;
    let [at_controller, at_plant] = NETWORK_ADDRESSES;
    for (end, address, far) in [
        (controller, at_controller, (at_plant, PLANT_MAC)),
        (plant, at_plant, (at_controller, CONTROLLER_MAC)),
    ] {
        end.run(|| configure_end(NETWORK_INTERFACE, address, far))?;
    }
    Ok(NETWORK_ADDRESSES)
}

/// Brings up an interface of this thread's namespace, with an address and a neighbour.
fn configure_end(interface: &str, address: Ipv4Addr, far: (Ipv4Addr, Mac)) -> Result<()> {
    let mut netlink = Netlink::open()?;
    let index = netlink.index_of(interface)?;
    netlink.add_address(index, address, PREFIX_LEN)?;
    netlink.bring_up(index)?;
    netlink.add_neighbour(index, far.0, far.1)
}

/// What lets packets cross an interface in a form that no wire carries: several segments merged into one of up to
/// 64 KiB, or packets without a checksum. `ETHTOOL_SGRO`, `_STSO`, `_SGSO` and `_STXCSUM` of `linux/ethtool.h`.
const OFFLOADS: [(u32, &str); 4] = [
    MERGING[0],
    (0x1f, "TCP segmentation offload"),
    (0x24, "generic segmentation offload"),
    (0x17, "transmit checksum offload"),
];

/// The one among them that waits for packets that came later.
const MERGING: [(u32, &str); 1] = [(0x2c, "generic receive offload")];

/// Lets packets cross an interface only as a wire carries them.
pub(crate) fn send_whole_packets(interface: &str) -> Result<()> {
    turn_off(&OFFLOADS, interface)
}

fn turn_off(offloads: &[(u32, &str)], interface: &str) -> Result<()> {
    // Any socket will do: the kernel only needs its namespace.
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).doing("open a socket")?;
    for (command, feature) in offloads {
        sys::set_feature(&socket, interface, *command, false)
            .doing_with(|| format!("turn off {feature} on `{interface}`"))?;
    }
    Ok(())
}
