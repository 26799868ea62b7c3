//! Where packets enter and leave the player: an `AF_PACKET` socket on an interface.
//!
//! The player knows ports only as [`Port`], so a [TUN device](crate::TunPort) or a [UDP
//! socket](crate::UdpPort) can take the place of an interface.

pub(crate) mod frame;
pub(crate) mod inbox;
mod offload;
pub(crate) mod tun;
pub(crate) mod udp;

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::Errno;
use rustix::net::{AddressFamily, SendFlags, SocketFlags, SocketType, sockopt};

use crate::error::{Doing, Error, Result};
use crate::network::netlink::Netlink;
use crate::port::inbox::Inbox;
use crate::port::offload::{OFFLOAD_HEADER, on_a_wire};
use crate::stamp::StampClock;
use crate::sys;

/// A packet that was received, or several that the sending kernel left for later to cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Bytes of the frame, in the buffer and as it is sent on.
    pub frame_bytes: usize,
    /// Where the IP packet begins in it.
    pub ip_at: usize,
    /// Packets that a wire would carry for it.
    pub packets: u32,
    /// Bytes of these packets, IP headers included, which a link counts.
    pub ip_bytes: u32,
    /// When the kernel received it, monotonic.
    pub stamp_ns: u64,
}

impl Arrival {
    /// A packet without anything before it.
    fn packet(bytes: usize, stamp_ns: u64) -> Self {
        Self {
            frame_bytes: bytes,
            ip_at: 0,
            packets: 1,
            // At most FRAME_MAX.
            ip_bytes: bytes as u32,
            stamp_ns,
        }
    }
}

/// Frames that a port has not passed on since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounters {
    /// Frames that are not IPv4 or come from an unknown sender: left out on purpose.
    pub foreign: u64,
    /// IPv4 packets that found no room: lost by the player itself.
    pub dropped: u64,
}

/// One side of the player, which receives and sends whole frames.
pub trait Port: AsFd {
    /// Takes the next packets without waiting, if there are any.
    ///
    /// # Errors
    /// Those of the kernel, for instance if the interface is gone.
    fn receive(&mut self, inbox: &mut Inbox) -> io::Result<()>;

    /// Sends one frame.
    ///
    /// # Errors
    /// If the kernel refuses; the frame has then not been sent.
    fn send(&mut self, frame: &[u8]) -> io::Result<()>;

    /// The frames that have not been passed on so far.
    ///
    /// # Errors
    /// If the kernel does not return its counters.
    fn counters(&mut self) -> io::Result<PortCounters>;
}

/// Room in the socket for packets that come while the player has no processor: at 100 000 small
/// packets a second (each takes about a kilobyte of kernel memory) it is a third of a second.
const SOCKET_BYTES: usize = 32 << 20;

/// Length of an Ethernet header; its last two bytes give the type of its contents.
pub(crate) const ETHERNET_HEADER: usize = 14;
/// The type of IPv4.
const ETHERTYPE_IPV4: [u8; 2] = [0x08, 0x00];

/// A packet socket on one interface of this thread's namespace.
///
/// It receives each incoming frame, with the kernel's receive stamp, and no outgoing ones. What the sending
/// kernel has left for later crosses with the frame, where this kernel tells it.
#[derive(Debug)]
pub struct PacketPort {
    socket: OwnedFd,
    /// Length of what tells that.
    offload_bytes: usize,
    stamps: StampClock,
    counters: PortCounters,
}

impl PacketPort {
    /// Opens the interface called `interface` in the namespace of the calling thread.
    ///
    /// # Errors
    /// [`Error::Failed`] if there is no such interface, [`Error::Unsupported`] if this process may
    /// not open packet sockets.
    pub fn open(interface: &str) -> Result<Self> {
        let index = Netlink::open()?.index_of(interface)?;
        let socket = packet_socket()?;
        let offload_bytes = match sys::tell_offload(&socket) {
            Ok(()) => OFFLOAD_HEADER,
            Err(error) => {
                tracing::debug!(%error, "only packets with whole checksums can cross");
                0
            }
        };
        // In this order: a socket without a protocol receives nothing until it is bound.
        sys::stamp_received(&socket)
            .and_then(|()| sys::ignore_outgoing(&socket))
            .and_then(|()| sys::bypass_qdisc(&socket))
            .and_then(|()| sys::bind_to_interface(&socket, index))
            .doing_with(|| format!("listen to the interface `{interface}`"))?;
        Ok(Self {
            socket,
            offload_bytes,
            stamps: StampClock::new(),
            counters: PortCounters::default(),
        })
    }
}

/// Whether the kernel tells packet sockets what it has left for later, so that segments can cross whole.
pub(crate) fn tells_offload() -> bool {
    let told = packet_socket().and_then(|socket| sys::tell_offload(&socket).doing("ask"));
    if let Err(error) = &told {
        tracing::debug!(%error, "segments are cut before they cross");
    }
    told.is_ok()
}

/// A packet socket with a large buffer, which receives nothing until it is bound.
pub(crate) fn packet_socket() -> Result<OwnedFd> {
    let socket = rustix::net::socket_with(
        AddressFamily::PACKET,
        SocketType::RAW,
        SocketFlags::CLOEXEC,
        None,
    )
    .map_err(|source| Error::Unsupported {
        action: "open a packet socket",
        remedy: "the player needs CAP_NET_RAW in its namespace: run webloop as root, or let \
                 it make a user namespace; in a container, --cap-add NET_RAW",
        source: source.into(),
    })?;
    widen(&socket);
    Ok(socket)
}

/// Requests the large buffer beyond the machine's limit, which only real root may do; any other user
/// gets what the limit allows.
pub(crate) fn widen(socket: &OwnedFd) {
    for granted in [
        sockopt::set_socket_recv_buffer_size_force(socket, SOCKET_BYTES)
            .or_else(|_| sockopt::set_socket_recv_buffer_size(socket, SOCKET_BYTES)),
        sockopt::set_socket_send_buffer_size_force(socket, SOCKET_BYTES)
            .or_else(|_| sockopt::set_socket_send_buffer_size(socket, SOCKET_BYTES)),
    ] {
        if let Err(error) = granted {
            tracing::debug!(%error, "the socket keeps its default buffer");
        }
    }
}

/// Whether these bytes begin like an IPv4 packet.
pub(crate) fn is_ipv4(packet: &[u8]) -> bool {
    packet.first().is_some_and(|first| first >> 4 == 4)
}

impl Port for PacketPort {
    fn receive(&mut self, inbox: &mut Inbox) -> io::Result<()> {
        let (counters, offload_bytes) = (&mut self.counters, self.offload_bytes);
        let ip_at = offload_bytes + ETHERNET_HEADER;
        let filled = inbox.fill(
            &self.socket,
            &mut self.stamps,
            |frame, received, stamp_ns| {
                if frame.get(ip_at - 2..ip_at) != Some(&ETHERTYPE_IPV4) {
                    counters.foreign += 1;
                    return None;
                }
                if received.len > frame.len() {
                    counters.dropped += 1;
                    return None;
                }
                let (packets, ip_bytes) = on_a_wire(&frame[..offload_bytes], &frame[ip_at..]);
                Some(Arrival {
                    frame_bytes: frame.len(),
                    ip_at,
                    packets,
                    ip_bytes,
                    stamp_ns,
                })
            },
        );
        match filled {
            // A segment of a kind that the kernel cannot tell of, and has dropped.
            Err(error)
                if offload_bytes > 0 && Errno::from_io_error(&error) == Some(Errno::INVAL) =>
            {
                self.counters.dropped += 1;
                Ok(())
            }
            filled => filled.map(drop),
        }
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        /// How often a receiver without room is given time to make room.
        const TRIES: usize = 100;
        let mut tries = 0;
        loop {
            match rustix::net::send(&self.socket, frame, SendFlags::empty()) {
                Ok(_) => return Ok(()),
                Err(Errno::NOBUFS | Errno::INTR | Errno::AGAIN) if tries < TRIES => {
                    tries += 1;
                    std::thread::yield_now();
                }
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn counters(&mut self) -> io::Result<PortCounters> {
        self.counters.dropped += sys::take_packet_drops(&self.socket)?;
        Ok(self.counters)
    }
}

impl AsFd for PacketPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}
