//! What a port has received with one system call, each packet in a frame that can be taken away.

use std::io;
use std::os::fd::OwnedFd;

use crate::port::Arrival;
use crate::port::frame::{Frame, Pool, new_frame, new_segment};
use crate::stamp::StampClock;
use crate::sys::{self, Received};

/// Frames taken from a port with one system call.
const BATCH: usize = 16;

/// What a port has received at once.
#[derive(Debug)]
pub struct Inbox {
    frames: [Frame; BATCH],
    received: [Option<Received>; BATCH],
    arrivals: [Option<Arrival>; BATCH],
    /// How many messages the last call took.
    count: usize,
}

impl Inbox {
    /// An inbox for packets, each as a wire carries it.
    pub(crate) fn of_packets() -> Self {
        Self::of(new_frame)
    }

    /// An inbox that has room for segments too.
    pub(crate) fn of_segments() -> Self {
        Self::of(new_segment)
    }

    fn of(room: fn() -> Frame) -> Self {
        Self {
            frames: std::array::from_fn(|_| room()),
            received: [None; BATCH],
            arrivals: [None; BATCH],
            count: 0,
        }
    }

    /// Takes messages from a socket; `arrival` says which are packets of the link. Returns how many there were.
    pub(crate) fn fill(
        &mut self,
        socket: &OwnedFd,
        stamps: &mut StampClock,
        mut arrival: impl FnMut(&[u8], Received, u64) -> Option<Arrival>,
    ) -> io::Result<usize> {
        self.count = 0;
        let frames = self.frames.each_mut().map(|frame| &mut frame[..]);
        self.count = sys::receive_batch(socket, frames, &mut self.received)?;
        if self.count > 0 {
            let reading = stamps.read();
            for index in 0..self.count {
                self.arrivals[index] = self.received[index].and_then(|received| {
                    let frame = &self.frames[index];
                    let stamp_ns = reading.monotonic_ns(received.stamp_ns);
                    arrival(&frame[..received.len.min(frame.len())], received, stamp_ns)
                });
            }
        }
        Ok(self.count)
    }

    /// Whether the port may have more than it has just received.
    pub(crate) fn is_full(&self) -> bool {
        self.count == BATCH
    }

    /// A packet with its frame, in place of which it leaves one of the pool. A packet in the room of a
    /// segment is copied.
    pub(crate) fn take(&mut self, index: usize, pool: &mut Pool) -> Option<(Arrival, Frame)> {
        let arrival = self.arrivals.get_mut(index)?.take()?;
        let mut spare = pool.take(arrival.frame_bytes);
        let frame = &mut self.frames[index];
        if spare.len() == frame.len() {
            std::mem::swap(frame, &mut spare);
        } else {
            let bytes = ..arrival.frame_bytes;
            spare[bytes].copy_from_slice(&frame[bytes]);
        }
        Some((arrival, spare))
    }

    /// How many places to look at.
    pub(crate) fn len(&self) -> usize {
        self.count
    }
}
