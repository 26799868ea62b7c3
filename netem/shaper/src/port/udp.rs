//! A port that leads to another player: each packet of the link in its own datagram, with nothing before it.
//!
//! The other player is known by its address and port. Datagrams from any other sender are counted and
//! discarded. This keeps stray packets out, but not a forger, who should not be on that network.

use std::io;
use std::net::SocketAddrV4;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::Errno;
use rustix::net::{AddressFamily, SendFlags, SocketFlags, SocketType};

use crate::error::{Doing, Result};
use crate::port::inbox::Inbox;
use crate::port::{Arrival, Port, PortCounters, is_ipv4, widen};
use crate::stamp::StampClock;
use crate::sys;

/// Bytes that a datagram adds to a packet: an IPv4 header without options, and a UDP header.
pub(crate) const UDP_HEADERS: u32 = 20 + 8;

/// The default UDP port of both players.
pub const TUNNEL_PORT: u16 = 7077;

/// A UDP socket that accepts one peer.
///
/// It is not connected to the peer, because then the first datagrams would fail if the peer is not there yet.
#[derive(Debug)]
pub struct UdpPort {
    socket: OwnedFd,
    peer: SocketAddrV4,
    stamps: StampClock,
    counters: PortCounters,
    /// Datagrams that the kernel received but that are too long for this port.
    oversized: u64,
}

impl UdpPort {
    /// Opens the local address in the namespace of the calling thread. With 0.0.0.0, the route to the
    /// peer decides which address the peer sees.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if the address is not on this machine or is in use.
    pub fn open(local: SocketAddrV4, peer: SocketAddrV4) -> Result<Self> {
        let socket = rustix::net::socket_with(
            AddressFamily::INET,
            SocketType::DGRAM,
            SocketFlags::CLOEXEC,
            None,
        )
        .doing("open a UDP socket")?;
        widen(&socket);
        sys::stamp_received(&socket)
            .and_then(|()| rustix::net::bind(&socket, &local).map_err(Into::into))
            .doing_with(|| format!("listen for the other player at UDP {local}"))?;
        Ok(Self {
            socket,
            peer,
            stamps: StampClock::new(),
            counters: PortCounters::default(),
            oversized: 0,
        })
    }
}

impl Port for UdpPort {
    fn receive(&mut self, inbox: &mut Inbox) -> io::Result<()> {
        let (counters, oversized, peer) = (&mut self.counters, &mut self.oversized, self.peer);
        inbox.fill(
            &self.socket,
            &mut self.stamps,
            |packet, received, stamp_ns| {
                if received.sender != Some(peer) || !is_ipv4(packet) {
                    counters.foreign += 1;
                    return None;
                }
                if received.len > packet.len() {
                    *oversized += 1;
                    return None;
                }
                Some(Arrival::packet(packet.len(), stamp_ns))
            },
        )?;
        Ok(())
    }

    /// Does not wait: a datagram for which the kernel has no room is lost, and counted.
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        loop {
            match rustix::net::sendto(&self.socket, frame, SendFlags::DONTWAIT, &self.peer) {
                Ok(_) => return Ok(()),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn counters(&mut self) -> io::Result<PortCounters> {
        self.counters.dropped = self.oversized + sys::datagram_drops(&self.socket)?;
        Ok(self.counters)
    }
}

impl AsFd for UdpPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::frame::{FRAME_MAX, Frame, Pool};
    use clock::now::now_ns;
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use std::net::{Ipv4Addr, UdpSocket};

    fn address(socket: &UdpSocket) -> SocketAddrV4 {
        SocketAddrV4::new(
            Ipv4Addr::LOCALHOST,
            socket.local_addr().expect("bound").port(),
        )
    }

    /// The next packets; waits at most two seconds.
    fn next(port: &mut UdpPort) -> Vec<(Arrival, Frame)> {
        let patience = Timespec {
            tv_sec: 2,
            tv_nsec: 0,
        };
        let mut ports = [PollFd::from_borrowed_fd(port.as_fd(), PollFlags::IN)];
        poll(&mut ports, Some(&patience)).expect("poll works");
        received(port)
    }

    /// What has come.
    fn received(port: &mut UdpPort) -> Vec<(Arrival, Frame)> {
        let (mut inbox, mut pool) = (Inbox::of_packets(), Pool::default());
        port.receive(&mut inbox).expect("the socket works");
        let packets = (0..inbox.len()).filter_map(|index| inbox.take(index, &mut pool));
        packets.collect()
    }

    #[test]
    fn only_the_peer_s_ipv4_comes_in() {
        let bind = || UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("loopback");
        let (peer, stranger, probe) = (bind(), bind(), bind());
        // The probe's port is free once it is closed.
        let local = address(&probe);
        drop(probe);
        let mut port = UdpPort::open(local, address(&peer)).expect("a free port");
        let packet = |first: u8, bytes: usize| {
            let mut packet = vec![7; bytes];
            packet[0] = first;
            packet
        };
        let send = |from: &UdpSocket, packet: &[u8]| {
            from.send_to(packet, local).expect("loopback");
        };
        send(&stranger, &packet(0x45, 84));
        send(&peer, &packet(0x60, 84));
        send(&peer, &[]);
        send(&peer, &packet(0x45, FRAME_MAX + 1));
        let before_ns = now_ns();
        send(&peer, &packet(0x45, 90));
        let packets = next(&mut port);
        let [(arrival, frame)] = packets.as_slice() else {
            panic!("only the peer's packet: {packets:?}");
        };
        assert_eq!((arrival.frame_bytes, arrival.ip_bytes), (90, 90));
        assert_eq!(&frame[..90], packet(0x45, 90));
        // The stamp is converted from another clock, to some microseconds.
        assert!((before_ns - 100_000..=now_ns()).contains(&arrival.stamp_ns));
        let counters = port.counters().expect("the socket works");
        assert_eq!((counters.foreign, counters.dropped), (3, 1));
        // The way back, from the port that the peer knows.
        port.send(&packet(0x45, 84)).expect("loopback");
        let (bytes, from) = peer.recv_from(&mut [0; FRAME_MAX]).expect("loopback");
        assert_eq!((bytes, from), (84, local.into()));
    }

    /// If the peer is not there yet, the kernel answers with an error; that must not end a play.
    #[test]
    fn a_peer_that_is_not_there_yet_is_no_error() {
        let bind = || UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("loopback");
        let (one, other) = (bind(), bind());
        let (local, peer) = (address(&one), address(&other));
        drop((one, other));
        let mut port = UdpPort::open(local, peer).expect("a free port");
        for _ in 0..3 {
            port.send(&[0x45; 84]).expect("the kernel takes it");
            assert!(received(&mut port).is_empty());
        }
    }

    #[test]
    fn what_the_socket_has_no_room_for_is_counted() {
        let bind = || UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("loopback");
        let (local, peer) = (address(&bind()), bind());
        let mut port = UdpPort::open(local, address(&peer)).expect("a free port");
        rustix::net::sockopt::set_socket_recv_buffer_size(&port.socket, 4096).expect("small");
        for _ in 0..100 {
            peer.send_to(&[0x45; 1400], local).expect("loopback");
        }
        let mut came = 0;
        loop {
            let packets = received(&mut port);
            if packets.is_empty() {
                break;
            }
            came += packets.len() as u64;
        }
        assert!(came < 100, "the buffer holds a few");
        let counters = port.counters().expect("the socket works");
        assert_eq!(counters.dropped, 100 - came);
    }
}
