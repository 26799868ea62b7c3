//! Where packets enter and leave the player: an `AF_PACKET` socket on an interface.
//!
//! The player knows ports only as [`Port`], so a [TUN device](crate::TunPort) or a [UDP
//! socket](crate::UdpPort) can take the place of an interface.

pub(crate) mod tun;
pub(crate) mod udp;

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::Errno;
use rustix::net::{AddressFamily, SendFlags, SocketFlags, SocketType, sockopt};

use crate::clock::StampClock;
use crate::error::{Doing, Error, Result};
use crate::network::netlink::Netlink;
use crate::sys::{self, Received};

/// Room for the longest possible frame: 1500 bytes of packet and 14 of Ethernet header, rounded up to
/// keep buffers on their own cache lines.
pub const FRAME_MAX: usize = 1536;

/// A packet that was received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Bytes of the frame, in the buffer and as it is sent on.
    pub frame_bytes: usize,
    /// Bytes of the IP packet in it, which a link counts.
    pub ip_bytes: u32,
    /// When the kernel received it, monotonic.
    pub stamp_ns: u64,
}

impl Arrival {
    /// A packet without anything before it.
    fn packet(bytes: usize, stamp_ns: u64) -> Self {
        Self {
            frame_bytes: bytes,
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

/// Frames taken from a port with one system call.
const BATCH: usize = 16;

/// Room for one frame.
pub(crate) type Frame = Box<[u8; FRAME_MAX]>;

/// Filled, not only zeroed, so that its page is mapped when a packet needs it.
pub(crate) fn new_frame() -> Frame {
    Box::new([0x77; FRAME_MAX])
}

/// What a port has received at once.
#[derive(Debug)]
pub struct Inbox {
    frames: [Frame; BATCH],
    received: [Option<Received>; BATCH],
    arrivals: [Option<Arrival>; BATCH],
    /// How many messages the last call took.
    count: usize,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            frames: std::array::from_fn(|_| new_frame()),
            received: [None; BATCH],
            arrivals: [None; BATCH],
            count: 0,
        }
    }
}

impl Inbox {
    /// Takes messages from a socket; `arrival` says which are packets of the link. Returns how many there were.
    fn fill(
        &mut self,
        socket: &OwnedFd,
        stamps: &mut StampClock,
        mut arrival: impl FnMut(&[u8], Received, u64) -> Option<Arrival>,
    ) -> io::Result<usize> {
        let frames = self.frames.each_mut().map(|frame| frame.as_mut_slice());
        self.count = sys::receive_batch(socket, frames, &mut self.received)?;
        if self.count > 0 {
            let reading = stamps.read();
            for index in 0..self.count {
                self.arrivals[index] = self.received[index].and_then(|received| {
                    let bytes = received.len.min(FRAME_MAX);
                    let stamp_ns = reading.monotonic_ns(received.stamp_ns);
                    arrival(&self.frames[index][..bytes], received, stamp_ns)
                });
            }
        }
        Ok(self.count)
    }

    /// Whether the port may have more than it has just received.
    pub(crate) fn is_full(&self) -> bool {
        self.count == BATCH
    }

    /// The packets, each with its frame, in place of which it leaves one of `spare`.
    pub(crate) fn take(
        &mut self,
        index: usize,
        spare: impl FnOnce() -> Frame,
    ) -> Option<(Arrival, Frame)> {
        let arrival = self.arrivals.get_mut(index)?.take()?;
        Some((arrival, std::mem::replace(&mut self.frames[index], spare())))
    }

    /// How many places to look at.
    pub(crate) fn len(&self) -> usize {
        self.count
    }
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
const ETHERNET_HEADER: usize = 14;
/// The type of IPv4.
const ETHERTYPE_IPV4: [u8; 2] = [0x08, 0x00];

/// A packet socket on one interface of this thread's namespace.
///
/// It receives each incoming frame, with the kernel's receive stamp, and no outgoing ones.
#[derive(Debug)]
pub struct PacketPort {
    socket: OwnedFd,
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
        // In this order: a socket without a protocol receives nothing until it is bound.
        sys::stamp_received(&socket)
            .and_then(|()| sys::ignore_outgoing(&socket))
            .and_then(|()| sys::bypass_qdisc(&socket))
            .and_then(|()| sys::bind_to_interface(&socket, index))
            .doing_with(|| format!("listen to the interface `{interface}`"))?;
        Ok(Self {
            socket,
            stamps: StampClock::new(),
            counters: PortCounters::default(),
        })
    }
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
        let counters = &mut self.counters;
        inbox.fill(
            &self.socket,
            &mut self.stamps,
            |frame, received, stamp_ns| {
                if frame.get(ETHERNET_HEADER - 2..ETHERNET_HEADER) != Some(&ETHERTYPE_IPV4) {
                    counters.foreign += 1;
                    return None;
                }
                if received.len > frame.len() {
                    counters.dropped += 1;
                    return None;
                }
                Some(Arrival {
                    frame_bytes: frame.len(),
                    // At most FRAME_MAX.
                    ip_bytes: (frame.len() - ETHERNET_HEADER) as u32,
                    stamp_ns,
                })
            },
        )?;
        Ok(())
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
