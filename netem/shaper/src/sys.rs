//! The system calls that no safe library offers, each behind a safe function. The crate has `unsafe`
//! only here and in the file below, `interface`.
//!
//! In all of them the pointers passed to the kernel point to live, initialised values on this stack
//! or to a caller's slice, and the lengths are those of the same values, so the kernel writes only
//! where it may.
#![allow(unsafe_code)]

mod interface;

use std::io;
use std::mem;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};

use clock::now::SECOND_NS;
use libc::{c_int, c_void, socklen_t};
use rustix::thread::UnshareFlags;

pub(crate) use interface::{make_tun, set_feature};

/// Options of `linux/if_packet.h`, `linux/icmp.h` and `asm-generic/socket.h` that the libc
/// crate leaves out.
const PACKET_STATISTICS: c_int = 6;
const PACKET_VNET_HDR: c_int = 15;
const PACKET_QDISC_BYPASS: c_int = 20;
const PACKET_IGNORE_OUTGOING: c_int = 23;
const ICMP_FILTER: c_int = 1;
const SO_MEMINFO: c_int = 55;

/// `struct tpacket_stats` of `linux/if_packet.h`.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct PacketStatistics {
    packets: u32,
    drops: u32,
}

/// Gives namespaces of its own to the calling thread (for the user namespace, to its process).
pub(crate) fn unshare(flags: Unshare) -> io::Result<()> {
    let flags = match flags {
        Unshare::Network => UnshareFlags::NEWNET,
        Unshare::User => UnshareFlags::NEWUSER,
    };
    // SAFETY: unsafe only because of `CLONE_FILES`, after which another thread may hold descriptors
    // that are no longer valid; neither flag here implies it.
    unsafe { rustix::thread::unshare_unsafe(flags) }.map_err(Into::into)
}

/// The namespace to unshare.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Unshare {
    /// `CLONE_NEWNET`: interfaces, addresses, routes.
    Network,
    /// `CLONE_NEWUSER`: users and capabilities.
    User,
}

/// Sets a socket option whose value is plain data.
fn set_option<T: Copy>(fd: BorrowedFd<'_>, level: c_int, name: c_int, value: T) -> io::Result<()> {
    // SAFETY: the kernel reads `size_of::<T>()` bytes of `value`, which is that long.
    let status = unsafe {
        libc::setsockopt(
            fd.as_raw_fd(),
            level,
            name,
            (&raw const value).cast::<c_void>(),
            socklen::<T>(),
        )
    };
    succeeded(status)
}

/// Asks the kernel to stamp what the socket receives (`SO_TIMESTAMPNS`).
pub(crate) fn stamp_received(fd: impl AsFd) -> io::Result<()> {
    set_option::<c_int>(fd.as_fd(), libc::SOL_SOCKET, libc::SO_TIMESTAMPNS, 1)
}

/// Lets a packet socket bypass the queueing discipline and send directly to the device.
pub(crate) fn bypass_qdisc(fd: impl AsFd) -> io::Result<()> {
    set_option::<c_int>(fd.as_fd(), libc::SOL_PACKET, PACKET_QDISC_BYPASS, 1)
}

/// Puts a `struct virtio_net_hdr` before each frame that a packet socket receives or sends: what the sending
/// kernel has left for later.
pub(crate) fn tell_offload(fd: impl AsFd) -> io::Result<()> {
    set_option::<c_int>(fd.as_fd(), libc::SOL_PACKET, PACKET_VNET_HDR, 1)
}

/// Keeps a packet socket from receiving what this machine sends through the interface.
pub(crate) fn ignore_outgoing(fd: impl AsFd) -> io::Result<()> {
    set_option::<c_int>(fd.as_fd(), libc::SOL_PACKET, PACKET_IGNORE_OUTGOING, 1)
}

/// Lets a packet socket receive only what this machine sends through the interface.
pub(crate) fn hear_only_outgoing(fd: impl AsFd) -> io::Result<()> {
    /// The offset at which a filter finds the type of a packet, by `linux/filter.h`.
    const PACKET_TYPE: u32 = (libc::SKF_AD_OFF + libc::SKF_AD_PKTTYPE).cast_unsigned();
    let step = |code: u32, jf, k| libc::sock_filter {
        code: code as u16,
        jt: 0,
        jf,
        k,
    };
    let mut program = [
        step(libc::BPF_LD | libc::BPF_B | libc::BPF_ABS, 0, PACKET_TYPE),
        // Any other type skips the next step.
        step(
            libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K,
            1,
            u32::from(libc::PACKET_OUTGOING),
        ),
        step(libc::BPF_RET | libc::BPF_K, 0, u32::MAX),
        step(libc::BPF_RET | libc::BPF_K, 0, 0),
    ];
    // The kernel copies the program, which lives on this stack during the whole call.
    let filter = libc::sock_fprog {
        len: program.len() as u16,
        filter: program.as_mut_ptr(),
    };
    set_option(fd.as_fd(), libc::SOL_SOCKET, libc::SO_ATTACH_FILTER, filter)
}

/// Lets a raw ICMP socket receive only one type of message.
pub(crate) fn hear_only_icmp(fd: impl AsFd, icmp_type: u8) -> io::Result<()> {
    debug_assert!(
        icmp_type < 32,
        "the filter has a bit for each type below 32"
    );
    // A set bit blocks its type.
    set_option::<u32>(fd.as_fd(), libc::SOL_RAW, ICMP_FILTER, !(1 << icmp_type))
}

/// Ties a packet socket to one interface, for all protocols.
pub(crate) fn bind_to_interface(fd: impl AsFd, index: u32) -> io::Result<()> {
    // SAFETY: all zeros is a valid `sockaddr_ll`: it is integers throughout.
    let mut address: libc::sockaddr_ll = unsafe { mem::zeroed() };
    address.sll_family = libc::AF_PACKET as u16;
    address.sll_protocol = (libc::ETH_P_ALL as u16).to_be();
    address.sll_ifindex = index.cast_signed();
    // SAFETY: the kernel reads `size_of::<sockaddr_ll>()` bytes of `address`.
    let status = unsafe {
        libc::bind(
            fd.as_fd().as_raw_fd(),
            (&raw const address).cast::<libc::sockaddr>(),
            socklen::<libc::sockaddr_ll>(),
        )
    };
    succeeded(status)
}

/// Reads a socket option whose value is plain data.
fn option<T: Copy + Default>(fd: BorrowedFd<'_>, level: c_int, name: c_int) -> io::Result<T> {
    let mut value = T::default();
    let mut len = socklen::<T>();
    // SAFETY: the kernel writes at most `len` bytes to `value`, which is that long.
    let status = unsafe {
        libc::getsockopt(
            fd.as_raw_fd(),
            level,
            name,
            (&raw mut value).cast::<c_void>(),
            &raw mut len,
        )
    };
    succeeded(status).map(|()| value)
}

/// Number of packets that the kernel has dropped since the last call because this packet socket was full.
pub(crate) fn take_packet_drops(fd: impl AsFd) -> io::Result<u64> {
    let statistics: PacketStatistics = option(fd.as_fd(), libc::SOL_PACKET, PACKET_STATISTICS)?;
    Ok(u64::from(statistics.drops))
}

/// Number of datagrams that the kernel has dropped since the socket was opened, because it was full
/// or their checksum was wrong.
pub(crate) fn datagram_drops(fd: impl AsFd) -> io::Result<u64> {
    /// The last count, except for what newer kernels may append.
    const DROPS: usize = libc::SK_MEMINFO_DROPS as usize;
    let memory: [u32; DROPS + 1] = option(fd.as_fd(), libc::SOL_SOCKET, SO_MEMINFO)?;
    Ok(u64::from(memory[DROPS]))
}

/// A message from a socket.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Received {
    /// Its true length, which exceeds the bytes read if the buffer was too short.
    pub(crate) len: usize,
    /// The kernel's receive stamp, wall-clock nanoseconds; `None` if there is none.
    pub(crate) stamp_ns: Option<u64>,
    /// Its sender; `None` if it has no IPv4 address and port.
    pub(crate) sender: Option<SocketAddrV4>,
}

/// More than enough room for the one control message that is requested.
#[derive(Clone, Copy)]
#[repr(align(8))]
struct Control([u8; 64]);

/// Takes the next message from a socket without waiting, with its kernel receive stamp. `None` if there is
/// nothing to read.
pub(crate) fn receive(fd: impl AsFd, buffer: &mut [u8]) -> io::Result<Option<Received>> {
    let mut received = [None];
    receive_batch(fd, [buffer], &mut received)?;
    Ok(received[0])
}

/// The same for several messages at once, each into a buffer of its own. Returns how many there were: fewer than
/// there are buffers if the socket is then empty.
pub(crate) fn receive_batch<const BATCH: usize>(
    fd: impl AsFd,
    buffers: [&mut [u8]; BATCH],
    received: &mut [Option<Received>; BATCH],
) -> io::Result<usize> {
    let mut controls = [Control([0; 64]); BATCH];
    // SAFETY: all zeros is a valid `sockaddr_in`, `iovec` and `mmsghdr`: integers, and null pointers with
    // zero lengths.
    let (mut senders, mut parts, mut headers): (
        [libc::sockaddr_in; BATCH],
        [libc::iovec; BATCH],
        [libc::mmsghdr; BATCH],
    ) = unsafe { (mem::zeroed(), mem::zeroed(), mem::zeroed()) };
    for (index, buffer) in buffers.into_iter().enumerate() {
        parts[index] = libc::iovec {
            iov_base: buffer.as_mut_ptr().cast::<c_void>(),
            iov_len: buffer.len(),
        };
        let header = &mut headers[index].msg_hdr;
        // An address of another family is longer: the kernel truncates it and reports its family.
        header.msg_name = (&raw mut senders[index]).cast::<c_void>();
        header.msg_namelen = socklen::<libc::sockaddr_in>();
        header.msg_iov = &raw mut parts[index];
        header.msg_iovlen = 1;
        header.msg_control = controls[index].0.as_mut_ptr().cast::<c_void>();
        header.msg_controllen = controls[index].0.len() as _;
    }
    // SAFETY: the kernel writes at most `BATCH` of `headers`, and for each at most `iov_len` bytes to its
    // buffer, `msg_controllen` to its control and `msg_namelen` to its sender; all outlive the call and
    // nothing else refers to them during it.
    let count = unsafe {
        libc::recvmmsg(
            fd.as_fd().as_raw_fd(),
            headers.as_mut_ptr(),
            BATCH as libc::c_uint,
            (libc::MSG_DONTWAIT | libc::MSG_TRUNC) as _,
            std::ptr::null_mut(),
        )
    };
    let Ok(count) = usize::try_from(count) else {
        let error = io::Error::last_os_error();
        return match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted => Ok(0),
            _ => Err(error),
        };
    };
    for (index, header) in headers.iter().take(count).enumerate() {
        let sender = senders[index];
        received[index] = Some(Received {
            len: header.msg_len as usize,
            stamp_ns: stamp(&header.msg_hdr),
            sender: (i32::from(sender.sin_family) == libc::AF_INET).then(|| {
                SocketAddrV4::new(
                    Ipv4Addr::from(u32::from_be(sender.sin_addr.s_addr)),
                    u16::from_be(sender.sin_port),
                )
            }),
        });
    }
    Ok(count)
}

/// The receive stamp among the control messages of a header filled by `recvmmsg`.
fn stamp(header: &libc::msghdr) -> Option<u64> {
    // SAFETY: `header` was filled by `recvmmsg`, so `msg_control` is a well-formed chain of
    // `msg_controllen` bytes in an aligned buffer that is still alive. The macros stay
    // inside it, and the datum is read unaligned, as C does with `memcpy`, only after its
    // type and length have been checked.
    unsafe {
        let mut message = libc::CMSG_FIRSTHDR(header);
        while let Some(found) = message.as_ref() {
            if found.cmsg_level == libc::SOL_SOCKET
                && found.cmsg_type == libc::SCM_TIMESTAMPNS
                && found.cmsg_len >= libc::CMSG_LEN(socklen::<libc::timespec>()) as _
            {
                let time = libc::CMSG_DATA(found)
                    .cast::<libc::timespec>()
                    .read_unaligned();
                return Some(time.tv_sec.unsigned_abs() * SECOND_NS + time.tv_nsec.unsigned_abs());
            }
            message = libc::CMSG_NXTHDR(header, found);
        }
    }
    None
}

/// The size of `T` in the type that socket calls need. Every `T` here has only a few bytes.
fn socklen<T>() -> socklen_t {
    size_of::<T>() as socklen_t
}

fn succeeded(status: c_int) -> io::Result<()> {
    if status == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}
