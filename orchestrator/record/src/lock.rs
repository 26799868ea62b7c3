//! The lock of a folder that one process writes to at a time, and who has it.
//!
//! The kernel gives the lock back when that process ends, however it ends. It lists its locks with the processes that
//! have them, for people only.

use std::fmt;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::MetadataExt;

use rustix::fs::{FlockOperation, flock, major, minor};
use rustix::io::Errno;

/// Why a file is not locked.
#[derive(Debug)]
pub enum NotLocked {
    /// Another process has the lock.
    InUse(Holder),
    /// Its file system has no such locks.
    Unsupported(io::Error),
    /// Anything else, such as a server of locks that does not answer.
    Other(io::Error),
}

/// The process that has a lock; `None` if its number cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Holder(pub Option<u32>);

impl fmt::Display for Holder {
    /// Continues "in use by another run": ` (process 1234)`, or nothing.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(pid) => write!(f, " (process {pid})"),
            None => Ok(()),
        }
    }
}

/// Takes the lock of a file without waiting. It ends when the file is closed.
///
/// # Errors
/// [`NotLocked`] says whether somebody else has it, or what keeps it from being taken.
pub fn lock(file: &File) -> Result<(), NotLocked> {
    flock(file, FlockOperation::NonBlockingLockExclusive).map_err(|problem| of(problem, file))
}

fn of(problem: Errno, file: &File) -> NotLocked {
    match problem {
        Errno::WOULDBLOCK => NotLocked::InUse(Holder(holder(file))),
        Errno::NOSYS | Errno::OPNOTSUPP => NotLocked::Unsupported(problem.into()),
        problem => NotLocked::Other(problem.into()),
    }
}

/// The process that has the lock, by the kernel's list; `None` where that does not show it.
fn holder(file: &File) -> Option<u32> {
    let found = file.metadata().ok()?;
    let (device, inode) = (found.dev(), found.ino());
    let of_file = format!("{:02x}:{:02x}:{inode}", major(device), minor(device));
    let text = fs::read_to_string("/proc/locks").ok()?;
    text.lines()
        .filter(|line| line.contains("FLOCK"))
        .find_map(|line| {
            // `1: FLOCK  ADVISORY  WRITE 1234 fe:00:5678 0 EOF`
            let mut fields = line.split_ascii_whitespace().skip(4);
            let pid = fields.next()?.parse().ok()?;
            (fields.next()? == of_file && pid != 0).then_some(pid)
        })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn who_has_a_lock_is_named_and_a_closed_file_gives_it_back() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("lock");
        let open = || crate::file::open_or_create(&path).unwrap();
        let (one, other) = (open(), open());
        lock(&one).unwrap();
        match lock(&other) {
            // In a container the list may be empty.
            Err(NotLocked::InUse(Holder(pid))) => {
                assert!(pid.is_none_or(|pid| pid == std::process::id()));
            }
            other => panic!("{other:?}"),
        }
        drop(one);
        lock(&other).unwrap();
    }

    #[test]
    fn each_refusal_of_the_system_is_told_as_what_it_is() {
        let place = tempfile::tempdir().unwrap();
        let file = crate::file::open_or_create(&place.path().join("lock")).unwrap();
        assert!(matches!(
            of(Errno::WOULDBLOCK, &file),
            NotLocked::InUse(Holder(None))
        ));
        for none in [Errno::NOSYS, Errno::OPNOTSUPP] {
            assert!(matches!(of(none, &file), NotLocked::Unsupported(_)));
        }
        for other in [
            Errno::NOLCK,
            Errno::ROFS,
            Errno::ACCESS,
            Errno::BADF,
            Errno::INTR,
            Errno::IO,
        ] {
            match of(other, &file) {
                NotLocked::Other(said) => {
                    assert_eq!(said.raw_os_error(), Some(other.raw_os_error()));
                }
                wrong => panic!("{other:?} is told as {wrong:?}"),
            }
        }
    }
}
