//! The half of a probe at the plant: it stamps the requests that reach the plant, of any probe. The
//! plant's kernel answers them.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::atomic::{AtomicBool, Ordering};

use clock::now::timespec;
use link::certificate::Sighting;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

use crate::error::{Doing, Result};
use crate::probe::hearer::Hearer;
use crate::probe::icmp;
use crate::probe::thread::{LONGEST_SLEEP_NS, on_a_thread};

/// A socket that receives requests.
///
/// It stays in the namespace in which it was opened, so any thread can run it.
#[derive(Debug)]
pub struct Witness {
    hearer: Hearer,
}

impl Witness {
    /// Opens the socket in the namespace of the calling thread.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if this process may not open raw
    /// sockets.
    pub fn open() -> Result<Self> {
        Hearer::open(icmp::REQUEST).map(|hearer| Self { hearer })
    }

    /// Reports each request as it comes, until `stop` is set; reports all that came before that.
    ///
    /// Runs on a thread of its own, for which it requests real-time scheduling, and waits for that
    /// thread. `on_sighting` must therefore neither wait nor write.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) if the socket fails.
    pub fn run(
        &mut self,
        stop: &AtomicBool,
        mut on_sighting: impl FnMut(Sighting) + Send,
    ) -> Result<()> {
        on_a_thread("witness", || {
            while !stop.load(Ordering::Relaxed) {
                self.wait()?;
                self.drain(&mut on_sighting)?;
            }
            self.drain(on_sighting)
        })
    }

    /// Reports each request that has come.
    pub(crate) fn drain(&mut self, mut on_sighting: impl FnMut(Sighting)) -> Result<()> {
        self.hearer.drain(|id, t_reach_ns| {
            on_sighting(Sighting {
                id: id.probe,
                seq: id.seq,
                t_reach_ns,
            });
        })
    }

    fn wait(&self) -> Result<()> {
        let mut sockets = [PollFd::from_borrowed_fd(self.as_fd(), PollFlags::IN)];
        match poll(&mut sockets, Some(&timespec(LONGEST_SLEEP_NS))) {
            // After a signal the caller checks `stop`.
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(io::Error::from(error)).doing("wait for echoes"),
        }
    }
}

impl AsFd for Witness {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.hearer.as_fd()
    }
}
