//! A raw ICMP socket, used by both halves of a probe: it receives one type of message, each with the
//! kernel's receive stamp.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use clock::now::now_ns;
use rustix::net::{AddressFamily, SocketFlags, SocketType, ipproto};

use crate::error::{Doing, Error, Result};
use crate::port::widen;
use crate::probe::icmp::{self, EchoId};
use crate::stamp::StampClock;
use crate::sys;

/// The socket. It stays in the namespace in which it was opened.
#[derive(Debug)]
pub(crate) struct Hearer {
    socket: OwnedFd,
    icmp_type: u8,
    stamps: StampClock,
}

impl Hearer {
    pub(crate) fn open(icmp_type: u8) -> Result<Self> {
        let socket = rustix::net::socket_with(
            AddressFamily::INET,
            SocketType::RAW,
            SocketFlags::CLOEXEC,
            Some(ipproto::ICMP),
        )
        .map_err(|source| Error::Unsupported {
            action: "open a raw ICMP socket",
            remedy: "probing needs CAP_NET_RAW in the ends' namespaces: run webloop as root, or \
                     let it make a user namespace; in a container, --cap-add NET_RAW",
            source: source.into(),
        })?;
        widen(&socket);
        sys::hear_only_icmp(&socket, icmp_type)
            .and_then(|()| sys::stamp_received(&socket))
            .doing("prepare a raw ICMP socket")?;
        Ok(Self {
            socket,
            icmp_type,
            stamps: StampClock::new(),
        })
    }

    /// Takes all messages that have come, and passes on each echo with its time.
    pub(crate) fn drain(&mut self, mut heard: impl FnMut(EchoId, u64)) -> Result<()> {
        let mut packet = [0; 256];
        while let Some(received) =
            sys::receive(&self.socket, &mut packet).doing("receive an echo")?
        {
            let bytes = &packet[..received.len.min(packet.len())];
            if let Some(id) = icmp::parse(bytes, self.icmp_type) {
                let stamp_ns = received
                    .stamp_ns
                    .map_or_else(now_ns, |stamp| self.stamps.monotonic_ns(stamp));
                heard(id, stamp_ns);
            }
        }
        Ok(())
    }
}

impl AsFd for Hearer {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}
