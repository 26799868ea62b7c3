//! Network namespaces that have no name: the kernel keeps them for as long as a process or
//! a descriptor is in them, so nothing is left behind however the program ends.
//!
//! How interfaces come into them is the business of [`veth`](crate::network::veth).

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

/// What lets this process make namespaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Authority {
    /// It has the capabilities, as root has.
    Privileged,
    /// It has them in a user namespace of its own.
    UserNamespace,
}

/// Makes sure that this process may make and fill network namespaces.
///
/// A process that has the capabilities already stays as it is. Any other enters a user
/// namespace of its own, in which it appears as root; outside of it, it can do no more than
/// before. Call it first thing in `main`: the kernel lets only a process with a single
/// thread enter a user namespace.
///
/// # Errors
/// [`Error::Unsupported`], with the remedy, where user namespaces are forbidden;
/// [`Error::Failed`] when the process has other threads.
pub fn become_root() -> Result<Authority> {
    if has_capabilities() {
        return Ok(Authority::Privileged);
    }
    // The numbers outside, which cannot be asked for any more from the inside.
    let (user, group) = (geteuid().as_raw(), getegid().as_raw());
    sys::unshare(Unshare::User).map_err(|source| match Errno::from_io_error(&source) {
        Some(Errno::INVAL) => Error::Failed {
            action: "enter a user namespace from a process with several threads".into(),
            source,
        },
        _ => forbidden(source),
    })?;
    // Without this the kernel would let no group map be written by an unprivileged process.
    write_map("setgroups", "deny")?;
    write_map("uid_map", &format!("0 {user} 1"))?;
    write_map("gid_map", &format!("0 {group} 1"))?;
    // Some distributions let the user namespace be made and then give it no capabilities.
    // A trial shows that, and it is undone with the thread.
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
    /// Makes one. The calling thread stays where it is.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where this process may not; see [`become_root`].
    pub fn new() -> Result<Self> {
        // A namespace is entered by the thread that makes it: a short-lived one, therefore.
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

    /// Moves the calling thread, and no other, into this namespace for good.
    ///
    /// # Errors
    /// [`Error::Failed`] if the kernel refuses.
    pub fn enter(&self) -> Result<()> {
        move_into_link_name_space(self.handle.as_fd(), Some(LinkNameSpaceType::Network))
            .doing("enter a network namespace")
    }

    /// Does something inside this namespace, on a thread of its own, and waits for it.
    /// Sockets that are made there stay there, whoever uses them.
    ///
    /// # Errors
    /// What `action` answers, or [`Error::Failed`] if the namespace cannot be entered.
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

/// Keeps the kernel from speaking IPv6 on interfaces still to come. The player forwards none
/// of it, so a kernel without IPv6 or a read-only `/proc/sys` costs only that its chatter is
/// counted as foreign: nothing to fail for.
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
