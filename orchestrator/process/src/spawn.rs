//! Starts a child that cannot outlive its parent: one of webloop's own roles, or a program of somebody's
//! own, which in addition is confined.
//!
//! The kernel kills the child when the thread that started it dies, however that happens. The
//! namespaces of a run have no names, so they disappear with the last process in them. Only this
//! module of the crate has `unsafe` code: `pre_exec` runs between fork and exec.
#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command};

use rustix::io::Errno;
use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal,
};
use rustix::thread::{
    CapabilitySet, LinkNameSpaceType, UnshareFlags, move_into_link_name_space,
    remove_capability_from_bounding_set, set_no_new_privs, unshare_unsafe,
};

use crate::shelter::Shelter;

/// What a confined program cannot do, whoever starts it: leave its namespaces, change its network or send
/// packets past it, look into other processes, or change the machine.
const TAKEN: [CapabilitySet; 14] = [
    CapabilitySet::SYS_ADMIN,
    // By a file's handle it could be opened past what covers it.
    CapabilitySet::DAC_READ_SEARCH,
    CapabilitySet::CHECKPOINT_RESTORE,
    CapabilitySet::NET_ADMIN,
    CapabilitySet::NET_RAW,
    CapabilitySet::SYS_PTRACE,
    CapabilitySet::SYS_MODULE,
    CapabilitySet::SYS_RAWIO,
    CapabilitySet::SYS_BOOT,
    CapabilitySet::SYS_TIME,
    CapabilitySet::SYS_CHROOT,
    CapabilitySet::MKNOD,
    CapabilitySet::BPF,
    CapabilitySet::PERFMON,
];

/// Makes `command`, once spawned, die with the calling thread, and start inside `namespace` if one
/// is given.
///
/// # Errors
/// When the namespace's descriptor cannot be duplicated.
pub fn bind(command: &mut Command, namespace: Option<&impl AsFd>) -> io::Result<()> {
    let namespace: Option<OwnedFd> = namespace
        .map(|ns| ns.as_fd().try_clone_to_owned())
        .transpose()?;
    let parent = getpid();
    // SAFETY: between fork and exec only async-signal-safe calls are allowed; these are three
    // bare system calls, on a descriptor that was duplicated before the fork.
    unsafe {
        command.pre_exec(move || {
            if let Some(namespace) = &namespace {
                move_into_link_name_space(namespace.as_fd(), Some(LinkNameSpaceType::Network))?;
            }
            die_with(Some(parent))
        });
    }
    Ok(())
}

/// Asks the kernel to kill this process when the thread that started it dies.
///
/// `parent` is the expected parent. If it is already gone, the request would never take effect, so
/// that is an error.
///
/// # Errors
/// When the request is refused or the parent is gone.
pub fn die_with(parent: Option<Pid>) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    if parent.is_some() && getppid() != parent {
        return Err(io::Error::from(io::ErrorKind::BrokenPipe));
    }
    Ok(())
}

/// Lets the calling thread's next child be the first process of a PID namespace: with it all processes in
/// the namespace end, and none of them reaches one outside.
///
/// # Errors
/// When this user may not make namespaces.
pub fn separate() -> io::Result<()> {
    // SAFETY: files stay shared; only children that are started from now on are concerned.
    Ok(unsafe { unshare_unsafe(UnshareFlags::NEWPID) }?)
}

/// Makes `command`, once spawned, die with the calling thread, and takes from it and its descendants what a
/// controller does not need, also if it runs as root. It does not see what the shelter covers: it has mounts of its
/// own, where the calling thread has been [separated](separate).
pub(crate) fn confine(command: &mut Command, shelter: Shelter) {
    // SAFETY: between fork and exec only async-signal-safe calls are allowed; these are bare system
    // calls, with paths that were made before the fork. In its own PID namespace the child does not see its
    // parent, so it cannot check for it. It has one thread, so nobody shares what is unshared.
    unsafe {
        command.pre_exec(move || {
            unshare_unsafe(UnshareFlags::NEWNS)?;
            shelter.enter()?;
            for capability in TAKEN {
                match remove_capability_from_bounding_set(capability) {
                    // An older kernel has fewer of them.
                    Err(Errno::INVAL) | Ok(()) => {}
                    Err(problem) => return Err(problem.into()),
                }
            }
            set_no_new_privs(true)?;
            die_with(None)
        });
    }
}

/// Sends SIGTERM to a child that still runs.
pub fn terminate(child: &mut Child) {
    // The kernel does not reuse its process number until it has been waited for.
    if matches!(child.try_wait(), Ok(None))
        && let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw)
    {
        let _ = kill_process(pid, Signal::TERM);
    }
}
