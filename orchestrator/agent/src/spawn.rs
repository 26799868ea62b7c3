//! Starts one of webloop's own roles as a child that cannot outlive its parent.
//!
//! The kernel kills the child when the thread that started it dies, by any death; since the
//! namespaces of a run have no names, they go with the last process in them. This is the one
//! place of the crate with `unsafe`: `pre_exec` runs between fork and exec.
#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command};

use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal,
};
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};

/// Makes `command`, once spawned, die with the calling thread, and start inside `namespace`
/// where one is given.
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
/// `parent` is who that should be; if it is already gone, the request would never fire, so this
/// is an error instead.
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

/// Sends SIGTERM to a child that still runs.
pub fn terminate(child: &mut Child) {
    // Its number is not reused until it has been waited for.
    if matches!(child.try_wait(), Ok(None))
        && let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw)
    {
        let _ = kill_process(pid, Signal::TERM);
    }
}
