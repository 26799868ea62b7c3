//! The half of a probe that is at the plant: it stamps the requests that reach it, of
//! whatever probe. The plant's kernel answers them.

use std::collections::HashMap;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use serde::{Deserialize, Serialize};

use crate::clock::timespec;
use crate::error::{Doing, Result};
use crate::hearer::Hearer;
use crate::icmp;
use crate::probe::{Echo, LONGEST_SLEEP_NS, on_a_thread};

/// A request that reached the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Sighting {
    /// The id of the probe that it belongs to.
    pub id: u16,
    /// Its number in that.
    pub seq: u32,
    /// When the plant's kernel received it, monotonic.
    pub t_reach_ns: u64,
}

/// A socket that hears requests.
///
/// It stays in the namespace that it was opened in, so any thread can run it.
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

    /// Tells each request as it comes, until `stop` is set; what came before that is told.
    ///
    /// It does so on a thread of its own, for which it asks real-time scheduling, and waits
    /// for that. So `on_sighting` must neither wait nor write.
    ///
    /// # Errors
    /// [`Error::Failed`](crate::Error::Failed) when the socket fails.
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

    /// Tells each request that has come.
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
            // A signal is a reason to look at `stop`.
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

/// What the asker of the probe `id` knows, together with what the witness saw of it: the
/// first sighting of each echo, in whatever order they come.
#[must_use]
pub fn merge(echoes: &[Echo], id: u16, sightings: &[Sighting]) -> Vec<Echo> {
    let mut reached: HashMap<u32, u64> = HashMap::with_capacity(echoes.len());
    for sighting in sightings.iter().filter(|sighting| sighting.id == id) {
        reached
            .entry(sighting.seq)
            .and_modify(|first_ns| *first_ns = sighting.t_reach_ns.min(*first_ns))
            .or_insert(sighting.t_reach_ns);
    }
    echoes
        .iter()
        .map(|echo| Echo {
            t_reach_ns: reached.get(&echo.seq).copied(),
            ..*echo
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ID: u16 = 7;

    fn echo(seq: u32) -> Echo {
        Echo {
            seq,
            t_send_ns: u64::from(seq) * 1000,
            t_reach_ns: None,
            t_back_ns: Some(u64::from(seq) * 1000 + 400),
        }
    }

    proptest! {
        /// Of each echo any number of sightings, in any order, among those of another probe
        /// and of numbers that were never sent: the first in time is what counts, an echo
        /// without one did not arrive, and what the asker knew stays.
        #[test]
        fn the_first_sighting_counts_in_whatever_order_they_come(
            delays_ns in prop::collection::vec(prop::collection::vec(1_u64..1000, 0..3), 0..50),
            order in any::<prop::sample::Index>(),
        ) {
            let echoes: Vec<Echo> = (0..delays_ns.len() as u32).map(echo).collect();
            let mut sightings = vec![Sighting { id: ID, seq: 1 << 20, t_reach_ns: 5 }];
            for (echo, delays_ns) in echoes.iter().zip(&delays_ns) {
                sightings.push(Sighting { id: ID + 1, seq: echo.seq, t_reach_ns: 1 });
                sightings.extend(delays_ns.iter().map(|delay_ns| Sighting {
                    id: ID,
                    seq: echo.seq,
                    t_reach_ns: echo.t_send_ns + delay_ns,
                }));
            }
            let middle = order.index(sightings.len());
            sightings.rotate_left(middle);
            sightings[..middle].reverse();
            let merged = merge(&echoes, ID, &sightings);
            prop_assert_eq!(merged.len(), echoes.len());
            for ((echo, merged), delays_ns) in echoes.iter().zip(&merged).zip(&delays_ns) {
                let first_ns = delays_ns.iter().min().map(|delay_ns| echo.t_send_ns + delay_ns);
                prop_assert_eq!(*merged, Echo { t_reach_ns: first_ns, ..*echo });
            }
        }
    }
}
