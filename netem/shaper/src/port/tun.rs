//! A port that is an interface of an end: a TUN device in the end's namespace, for the player that
//! runs beside that end.
//!
//! Packets written into the device reach the end. Packets from the end could be read from it too, but
//! without the time at which they were sent, so a player that loses its processor would play another
//! link. Therefore a packet socket listens at the device, for which the kernel stamps each packet,
//! and the packets in the device itself are discarded.
//!
//! The device has no Ethernet, so no ARP either. It ends with the process, however that ends.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;

use link::Way;
use rustix::io::Errno;

use crate::error::{Doing, Error, Result};
use crate::network::netlink::Netlink;
use crate::network::veth::{CONTROLLER_ADDRESS, END_INTERFACE, PLANT_ADDRESS, PREFIX_LEN};
use crate::port::inbox::Inbox;
use crate::port::udp::UDP_HEADERS;
use crate::port::{Arrival, Port, PortCounters, is_ipv4, packet_socket};
use crate::stamp::StampClock;
use crate::sys;

/// The kernel's file for TUN devices.
const CONTROL: &str = "/dev/net/tun";

/// The action that fails without a TUN device or without the right to use it.
const ACTION: &str = "make the TUN device";

/// The longest packet: its datagram just fits a network that carries 1500 bytes.
const MTU_BYTES: u32 = 1500 - UDP_HEADERS;

/// A TUN device called [`END_INTERFACE`], which is up and has its end's address.
#[derive(Debug)]
pub struct TunPort {
    device: File,
    /// Receives what the end sends.
    tap: OwnedFd,
    way: Way,
    stamps: StampClock,
    counters: PortCounters,
}

impl TunPort {
    /// Makes the device in the namespace of the calling thread. `way` tells which end that is by the
    /// direction of its packets: the controller's go [up](Way::Up), the plant's [down](Way::Down).
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no TUN device, or if this process may not make one or
    /// listen to it; [`Error::Failed`] if the end already has an interface of this name.
    pub fn open(way: Way) -> Result<Self> {
        let device = open_control(CONTROL)?;
        sys::make_tun(&device, END_INTERFACE).map_err(|source| {
            match Errno::from_io_error(&source) {
                Some(Errno::PERM) => Error::Unsupported {
                    action: ACTION,
                    remedy: "it needs CAP_NET_ADMIN in its network namespace: run webloop as \
                             root; in a container, --cap-add NET_ADMIN",
                    source,
                },
                Some(Errno::BUSY | Errno::INVAL) => Error::Failed {
                    action: format!(
                        "make the TUN device `{END_INTERFACE}` (does another player run beside \
                         this end?)"
                    ),
                    source,
                },
                _ => Error::Failed {
                    action: format!("make the TUN device `{END_INTERFACE}`"),
                    source,
                },
            }
        })?;
        let mut netlink = Netlink::open()?;
        let index = netlink.index_of(END_INTERFACE)?;
        netlink.set_mtu(index, MTU_BYTES)?;
        netlink.add_address(index, address(way), PREFIX_LEN)?;
        netlink.bring_up(index)?;
        // One can listen only to an interface that is up.
        let tap = packet_socket()?;
        sys::stamp_received(&tap)
            .and_then(|()| sys::hear_only_outgoing(&tap))
            .and_then(|()| sys::bind_to_interface(&tap, index))
            .doing_with(|| format!("listen to the TUN device `{END_INTERFACE}`"))?;
        Ok(Self {
            device,
            tap,
            way,
            stamps: StampClock::new(),
            counters: PortCounters::default(),
        })
    }

    /// The direction of the end's packets.
    #[must_use]
    pub fn way(&self) -> Way {
        self.way
    }

    /// Removes a packet that the tap has received from the device. It does no harm if a packet is
    /// missing or stays: the tap also receives packets for which the device has no room.
    fn discard(&self) -> io::Result<()> {
        // The kernel truncates what does not fit.
        match rustix::io::read(&self.device, &mut [0; 1]) {
            Ok(_) | Err(Errno::AGAIN | Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

fn address(way: Way) -> std::net::Ipv4Addr {
    match way {
        Way::Up => CONTROLLER_ADDRESS,
        Way::Down => PLANT_ADDRESS,
    }
}

fn open_control(path: &str) -> Result<File> {
    let unsupported = |remedy| {
        move |source| Error::Unsupported {
            action: ACTION,
            remedy,
            source,
        }
    };
    OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(libc::O_NONBLOCK)
        .open(path)
        .map_err(|source| match source.kind() {
            // In a container without access to the device this error occurs too; otherwise the user
            // lacks the permission for the file.
            ErrorKind::PermissionDenied => unsupported(
                "/dev/net/tun is not accessible to this process: run webloop as root, or make it \
                 readable and writable; in a container, --device /dev/net/tun",
            )(source),
            _ => unsupported(
                "there is no /dev/net/tun: load the kernel module (modprobe tun), or use a \
                 kernel with CONFIG_TUN; in a container, --device /dev/net/tun",
            )(source),
        })
}

impl Port for TunPort {
    fn receive(&mut self, inbox: &mut Inbox) -> io::Result<()> {
        let counters = &mut self.counters;
        let count = inbox.fill(&self.tap, &mut self.stamps, |packet, received, stamp_ns| {
            if !is_ipv4(packet) {
                counters.foreign += 1;
                return None;
            }
            if received.len > packet.len() {
                counters.dropped += 1;
                return None;
            }
            Some(Arrival::packet(packet.len(), stamp_ns))
        })?;
        for _ in 0..count {
            self.discard()?;
        }
        Ok(())
    }

    /// The kernel accepts a packet as a whole, and at once.
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.device.write(frame).map(|_| ())
    }

    fn counters(&mut self) -> io::Result<PortCounters> {
        self.counters.dropped += sys::take_packet_drops(&self.tap)?;
        Ok(self.counters)
    }
}

impl AsFd for TunPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.tap.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_the_device_is_told_what_to_do() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("tun");
        let error = open_control(missing.to_str().expect("a plain path")).expect_err("no device");
        assert!(matches!(error, Error::Unsupported { .. }));
        let told = error.to_string();
        for part in [
            "make the TUN device",
            "modprobe tun",
            "--device /dev/net/tun",
        ] {
            assert!(told.contains(part), "{told}");
        }
    }

    /// A file that opens but is not a TUN device, as may happen in a misconfigured container.
    #[test]
    fn a_device_that_is_none_is_a_failure() {
        let null = open_control("/dev/null").expect("it opens");
        assert!(sys::make_tun(&null, END_INTERFACE).is_err());
    }
}
