//! The cables of a cell: `controller` and `plant` in the middle, each tied to the only
//! interface of its end.
//!
//! ```text
//!  controller's namespace        the middle         plant's namespace
//!   link0 10.77.0.1/30 ──── controller   plant ──── link0 10.77.0.2/30
//! ```
//!
//! The middle has no address: its kernel forwards nothing, so a packet gets across only
//! through the [player](crate::player). The two ends are neighbours on one subnet and know
//! each other's Ethernet address beforehand, so that no ARP is ever shaped.
//!
//! Ends that are to be joined by a [tunnel](crate::player::tunnel) get a cable of another kind, one
//! that stands for the network that the tunnel crosses.

use std::net::{Ipv4Addr, UdpSocket};
use std::os::fd::AsFd;

use crate::error::{Doing, Result};
use crate::network::namespace::Namespace;
use crate::network::netlink::{End, Mac, Netlink};
use crate::sys;

/// The controller's address on the link.
pub const CONTROLLER_ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 1);
/// The plant's address on the link.
pub const PLANT_ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 77, 0, 2);
/// The subnet of the two.
pub(crate) const PREFIX_LEN: u8 = 30;

/// The only interface that an end has besides loopback.
pub const END_INTERFACE: &str = "link0";
/// The interface in the middle that leads to the controller.
pub const CONTROLLER_INTERFACE: &str = "controller";
/// The interface in the middle that leads to the plant.
pub const PLANT_INTERFACE: &str = "plant";

/// The interface of an end to the network that a tunnel crosses.
const NETWORK_INTERFACE: &str = "network0";
/// The ends' addresses on that network, the controller's first.
const NETWORK_ADDRESSES: [Ipv4Addr; 2] = [Ipv4Addr::new(10, 78, 0, 1), Ipv4Addr::new(10, 78, 0, 2)];

/// Locally administered (the bit `0x02`), fixed, so that each end can learn the other's.
const CONTROLLER_MAC: Mac = [0x02, 0x77, 0, 0, 0, 1];
const PLANT_MAC: Mac = [0x02, 0x77, 0, 0, 0, 2];
const MIDDLE_CONTROLLER_MAC: Mac = [0x02, 0x77, 0, 0, 1, 1];
const MIDDLE_PLANT_MAC: Mac = [0x02, 0x77, 0, 0, 1, 2];

/// Joins the ends through the middle with two veth pairs, each interface made directly in
/// its namespace, so that a crash half-way strands nothing.
///
/// # Errors
/// [`Error::Unsupported`](crate::Error::Unsupported) on a kernel without veth,
/// [`Error::Failed`](crate::Error::Failed) if a step is refused.
pub fn join(controller: &Namespace, plant: &Namespace, middle: &Namespace) -> Result<()> {
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
            send_whole_packets(name)?;
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
            send_whole_packets(END_INTERFACE)?;
            configure_end(END_INTERFACE, address, far)
        })?;
    }
    Ok(())
}

/// Joins the ends by one cable that is no link, as a network of containers or machines joins
/// them: what a tunnel crosses. Its addresses are returned, the controller's first.
///
/// # Errors
/// As [`join`].
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

/// Turns off what would let packets cross an interface in a shape that no wire carries: several
/// segments glued to one of 64 KiB, or without their checksum.
pub(crate) fn send_whole_packets(interface: &str) -> Result<()> {
    /// `ETHTOOL_STSO`, `_SGSO`, `_SGRO` and `_STXCSUM` of `linux/ethtool.h`.
    const OFFLOADS: [(u32, &str); 4] = [
        (0x1f, "TCP segmentation offload"),
        (0x24, "generic segmentation offload"),
        (0x2c, "generic receive offload"),
        (0x17, "transmit checksum offload"),
    ];
    // Any socket will do: the kernel only asks which namespace it is in.
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).doing("open a socket")?;
    for (command, feature) in OFFLOADS {
        sys::set_feature(&socket, interface, command, false)
            .doing_with(|| format!("turn off {feature} on `{interface}`"))?;
    }
    Ok(())
}
