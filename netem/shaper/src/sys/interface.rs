//! Requests about an interface that exist only as ioctls, and so in no safe crate.
#![allow(unsafe_code)]

use std::io;
use std::mem;
use std::os::fd::{AsFd, AsRawFd};

use super::succeeded;

/// Sets a feature of an interface in the namespace of `socket`, with the ioctl of ethtool: netlink
/// can do the same, but not on older kernels.
pub(crate) fn set_feature(socket: impl AsFd, name: &str, command: u32, on: bool) -> io::Result<()> {
    /// `struct ethtool_value` of `linux/ethtool.h`.
    #[repr(C)]
    struct EthtoolValue {
        command: u32,
        data: u32,
    }
    let mut value = EthtoolValue {
        command,
        data: u32::from(on),
    };
    let mut request = interface_request(name)?;
    request.ifr_ifru.ifru_data = (&raw mut value).cast::<libc::c_char>();
    // SAFETY: the kernel reads and writes one `ifreq` and, through it, one `ethtool_value`;
    // both are alive for the whole call.
    let status = unsafe {
        libc::ioctl(
            socket.as_fd().as_raw_fd(),
            libc::SIOCETHTOOL as _,
            &raw mut request,
        )
    };
    succeeded(status)
}

/// Makes a TUN device of this name in the namespace of the calling thread: IP packets without a
/// header before them. `control` is an open `/dev/net/tun`, through which its packets pass; the
/// device ends when that is closed.
pub(crate) fn make_tun(control: impl AsFd, name: &str) -> io::Result<()> {
    /// The cast fits: both are single bits below the sixteenth.
    const FLAGS: libc::c_short = (libc::IFF_TUN | libc::IFF_NO_PI) as libc::c_short;
    let mut request = interface_request(name)?;
    request.ifr_ifru.ifru_flags = FLAGS;
    // SAFETY: the kernel reads and writes one `ifreq`, which is alive for the whole call.
    let status = unsafe {
        libc::ioctl(
            control.as_fd().as_raw_fd(),
            libc::TUNSETIFF as _,
            &raw mut request,
        )
    };
    succeeded(status)
}

/// A request about the interface of this name, otherwise empty.
fn interface_request(name: &str) -> io::Result<libc::ifreq> {
    // SAFETY: all zeros is a valid `ifreq`: integers and null pointers.
    let mut request: libc::ifreq = unsafe { mem::zeroed() };
    // The last byte stays zero: the kernel expects names to end with it.
    let room = request.ifr_name.len() - 1;
    if name.len() > room {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    for (to, from) in request.ifr_name.iter_mut().zip(name.bytes()) {
        *to = from.cast_signed() as libc::c_char;
    }
    Ok(request)
}
