//! A netfilter queue: the kernel holds the packets that a rule sends into it until it is told to
//! release each. Has only what that needs of `linux/netfilter/nfnetlink_queue.h`.

use std::io;

use netlink_sys::{Socket, SocketAddr, protocols::NETLINK_NETFILTER};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::time::Timespec;

/// `NFNL_SUBSYS_QUEUE`, at its place in a message's type.
const SUBSYSTEM: u16 = 3 << 8;
const PACKET: u16 = SUBSYSTEM;
const VERDICT: u16 = SUBSYSTEM + 1;
const CONFIG: u16 = SUBSYSTEM + 2;
/// `NLM_F_REQUEST`, `NLM_F_ACK` and `NLMSG_ERROR`.
const REQUEST: u16 = 1;
const ACKNOWLEDGE: u16 = 4;
const ERROR: u16 = 2;
/// Length of a message's header, and of that followed by netfilter's own header.
const HEADER: usize = 16;
const HEADERS: usize = 20;

/// A packet's number in its queue.
pub(crate) type PacketId = u32;

pub(crate) struct Queue {
    socket: Socket,
    number: u16,
}

impl Queue {
    /// Listens to the queue `number` of this thread's namespace. Dropping this ends the queue, and
    /// what is in it then is lost.
    pub(crate) fn open(number: u16) -> io::Result<Self> {
        let mut socket = Socket::new(NETLINK_NETFILTER)?;
        socket.bind_auto()?;
        socket.connect(&SocketAddr::new(0, 0))?;
        let queue = Self { socket, number };
        // NFQA_CFG_CMD: NFQNL_CFG_CMD_BIND; then NFQA_CFG_PARAMS: no bytes of packets, only their
        // metadata (NFQNL_COPY_META); then NFQA_CFG_QUEUE_MAXLEN.
        queue.ask(1, &[1, 0, 0, 0])?;
        queue.ask(2, &[0, 0, 0, 0, 1])?;
        queue.ask(3, &100_000_u32.to_be_bytes())?;
        queue.socket.set_non_blocking(true)?;
        Ok(queue)
    }

    /// Waits for packets, at most this long.
    pub(crate) fn wait(&self, timeout_ns: u64) -> io::Result<()> {
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: timeout_ns.min(999_999_999).cast_signed(),
        };
        let mut sockets = [PollFd::new(&self.socket, PollFlags::IN)];
        match poll(&mut sockets, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(problem) => Err(problem.into()),
        }
    }

    /// Calls `each` with every packet that has come, without waiting.
    pub(crate) fn take(&self, mut each: impl FnMut(PacketId)) -> io::Result<()> {
        loop {
            let buffer = match self.socket.recv_from_full() {
                Ok((buffer, _)) => buffer,
                Err(problem) if problem.kind() == io::ErrorKind::WouldBlock => return Ok(()),
                Err(problem) => return Err(problem),
            };
            messages(&buffer)
                .filter(|(kind, _)| *kind == PACKET)
                // NFQA_PACKET_HDR comes first, after 4 bytes of netfilter's header and 4 of its
                // own; it begins with the packet's number.
                .filter_map(|(_, body)| body.get(8..12)?.try_into().ok())
                .for_each(|id| each(u32::from_be_bytes(id)));
        }
    }

    /// Releases a packet.
    pub(crate) fn release(&self, id: PacketId) -> io::Result<()> {
        /// `NF_ACCEPT`.
        const ACCEPT: u32 = 1;
        let verdict = [ACCEPT.to_be_bytes(), id.to_be_bytes()].concat();
        // NFQA_VERDICT_HDR.
        self.send(VERDICT, 0, 2, &verdict)
    }

    /// Changes a setting of the queue, and checks the kernel's answer.
    fn ask(&self, attribute: u16, value: &[u8]) -> io::Result<()> {
        self.send(CONFIG, ACKNOWLEDGE, attribute, value)?;
        let (buffer, _) = self.socket.recv_from_full()?;
        let error = messages(&buffer)
            .find(|(kind, _)| *kind == ERROR)
            .and_then(|(_, body)| body.get(..4)?.try_into().ok())
            .map_or(0, i32::from_ne_bytes);
        match error {
            0 => Ok(()),
            number => Err(io::Error::from_raw_os_error(-number)),
        }
    }

    fn send(&self, kind: u16, flags: u16, attribute: u16, value: &[u8]) -> io::Result<()> {
        let padded = value.len().next_multiple_of(4);
        let mut message = Vec::with_capacity(HEADERS + 4 + padded);
        message.extend(((HEADERS + 4 + padded) as u32).to_ne_bytes());
        message.extend(kind.to_ne_bytes());
        message.extend((REQUEST | flags).to_ne_bytes());
        // A sequence number and a sender, which are not used.
        message.extend([0; 8]);
        // Any family, version 0, and the number of the queue.
        message.extend([0, 0]);
        message.extend(self.number.to_be_bytes());
        message.extend(((4 + value.len()) as u16).to_ne_bytes());
        message.extend(attribute.to_ne_bytes());
        message.extend(value);
        message.resize(HEADERS + 4 + padded, 0);
        self.socket.send(&message, 0).map(drop)
    }
}

/// The kinds and bodies of the messages in `buffer`.
fn messages(mut buffer: &[u8]) -> impl Iterator<Item = (u16, &[u8])> {
    std::iter::from_fn(move || {
        let length = u32::from_ne_bytes(buffer.get(..4)?.try_into().ok()?) as usize;
        let kind = u16::from_ne_bytes(buffer.get(4..6)?.try_into().ok()?);
        let body = buffer.get(HEADER..length)?;
        buffer = buffer.get(length.next_multiple_of(4)..).unwrap_or_default();
        Some((kind, body))
    })
}
