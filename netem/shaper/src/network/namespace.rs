//! Network namespaces without a name: the kernel keeps them as long as a process or a descriptor
//! refers to them, so nothing is left behind however the program ends.
//!
//! [`veth`](crate::network::veth) adds interfaces to them.

use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::thread;

use rustix::io::Errno;
use rustix::process::{getegid, geteuid};
use rustix::thread::{CapabilitySet, LinkNameSpaceType, move_into_link_name_space};
use serde::{Deserialize, Serialize};

use crate::error::{Doing, Error, Result};
use crate::network::netlink::Netlink;
use crate::sys::{self, Unshare};

/// What permits this process to make namespaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Authority {
    /// It has the capabilities, like root.
    Privileged,
    /// It has the capabilities in a user namespace of its own.
    UserNamespace,
}

/// Makes sure that this process may create and configure network namespaces.
///
/// A process that already has the capabilities stays as it is. Any other enters a user namespace of
/// its own, in which it appears as root; outside of it, it can do no more than before. Call this
/// first in `main`: the kernel lets only a single-threaded process enter a user namespace.
///
/// # Errors
/// [`Error::Unsupported`], with the remedy, if user namespaces are forbidden; [`Error::Failed`] if
/// the process has other threads.
pub fn become_root() -> Result<Authority> {
    if has_capabilities() {
        return Ok(Authority::Privileged);
    }
    // The ids outside, which cannot be read from the inside any more.
    let (user, group) = (geteuid().as_raw(), getegid().as_raw());
    sys::unshare(Unshare::User).map_err(|source| match Errno::from_io_error(&source) {
        Some(Errno::INVAL) => Error::Failed {
            action: "enter a user namespace from a process with several threads".into(),
            source,
        },
        _ => forbidden(source),
    })?;
    // Without this the kernel does not let an unprivileged process write a group map.
    write_map("setgroups", "deny")?;
    write_map("uid_map", &format!("0 {user} 1"))?;
    write_map("gid_map", &format!("0 {group} 1"))?;
    // Some distributions permit the user namespace but give it no capabilities. A trial shows that;
    // the namespace that it makes ends with its thread.
    Namespace::new().map(|_| Authority::UserNamespace)
}

fn has_capabilities() -> bool {
    let needed = CapabilitySet::SYS_ADMIN | CapabilitySet::NET_ADMIN | CapabilitySet::NET_RAW;
    rustix::thread::capabilities(None).is_ok_and(|sets| sets.effective.contains(needed))
}

fn write_map(file: &str, text: &str) -> Result<()> {
    match fs::write(format!("/proc/self/{file}"), text) {
        Err(source) if source.kind() == io::ErrorKind::PermissionDenied => Err(forbidden(source)),
        other => other.doing_with(|| format!("write {file} of the new user namespace")),
    }
}

fn forbidden(source: io::Error) -> Error {
    Error::Unsupported {
        action: "make network namespaces",
        remedy: "run webloop as root, or allow user namespaces: sysctl \
                 user.max_user_namespaces above 0, kernel.unprivileged_userns_clone=1 (Debian), \
                 kernel.apparmor_restrict_unprivileged_userns=0 (Ubuntu); in a container, give \
                 it --cap-add SYS_ADMIN --cap-add NET_ADMIN",
        source,
    }
}

/// A network namespace without a name, with its loopback interface up and IPv6 off.
#[derive(Debug)]
pub struct Namespace {
    handle: OwnedFd,
}

impl Namespace {
    /// Makes a namespace. The calling thread stays where it is.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if this process may not; see [`become_root`].
    pub fn new() -> Result<Self> {
        // The thread that makes a namespace also enters it, so a short-lived thread makes it.
        on_a_thread(|| {
            sys::unshare(Unshare::Network).map_err(|source| {
                match Errno::from_io_error(&source) {
                    Some(Errno::PERM | Errno::NOSPC | Errno::ACCESS) => forbidden(source),
                    _ => Error::Failed {
                        action: "make a network namespace".into(),
                        source,
                    },
                }
            })?;
            let handle = File::open("/proc/thread-self/ns/net")
                .doing("open the new network namespace (is /proc mounted?)")?
                .into();
            silence_ipv6();
            let mut netlink = Netlink::open()?;
            let loopback = netlink.index_of("lo")?;
            netlink.bring_up(loopback)?;
            Ok(Self { handle })
        })
    }

    /// Moves the calling thread, and no other, into this namespace permanently.
    ///
    /// # Errors
    /// [`Error::Failed`] if the kernel refuses.
    pub fn enter(&self) -> Result<()> {
        move_into_link_name_space(self.handle.as_fd(), Some(LinkNameSpaceType::Network))
            .doing("enter a network namespace")
    }

    /// Runs `action` inside this namespace, on a thread of its own, and waits for it. Sockets that it
    /// opens stay in the namespace, whichever thread uses them.
    ///
    /// # Errors
    /// Those of `action`, or [`Error::Failed`] if the namespace cannot be entered.
    pub fn run<T: Send>(&self, action: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        on_a_thread(|| {
            self.enter()?;
            action()
        })
    }
}

/// The descriptor that keeps the namespace alive, for a child's `pre_exec`.
impl AsFd for Namespace {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.handle.as_fd()
    }
}

/// Turns IPv6 off on interfaces that are added later. The player does not forward IPv6. With a
/// read-only `/proc/sys` its packets are only counted as foreign, and a kernel without IPv6 sends
/// none, so this never fails.
fn silence_ipv6() {
    for scope in ["all", "default"] {
        let switch = format!("/proc/sys/net/ipv6/conf/{scope}/disable_ipv6");
        if let Err(error) = fs::write(&switch, "1") {
            tracing::debug!(%error, switch, "IPv6 stays on");
        }
    }
}

fn on_a_thread<T: Send>(action: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    thread::scope(|scope| {
        thread::Builder::new()
            .name("namespace".into())
            .spawn_scoped(scope, action)
            .doing("start a thread")?
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
