//! Starts one of webloop's own roles as a child that cannot outlive its parent.
//!
//! The kernel kills the child when the thread that started it dies, however that happens. The
//! namespaces of a run have no names, so they disappear with the last process in them. Only this
//! module of the crate has `unsafe` code: `pre_exec` runs between fork and exec.
#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command};

use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal,
};
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};

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

/// Sends SIGTERM to a child that still runs.
pub fn terminate(child: &mut Child) {
    // The kernel does not reuse its process number until it has been waited for.
    if matches!(child.try_wait(), Ok(None))
        && let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw)
    {
        let _ = kill_process(pid, Signal::TERM);
    }
}
