//! Room for frames: small ones for packets, large ones for segments that cross whole.
//!
//! A frame that is no longer needed is used again, so that in the steady state none is allocated.

/// Room for the longest frame of a packet that a wire carries: 1500 bytes of packet, 14 of Ethernet header and
/// 10 of [offload](crate::port::offload), rounded up to keep buffers on their own cache lines.
pub const FRAME_MAX: usize = 1536;

/// Room for the longest frame of a segment, of 65 535 bytes with the same headers, and as much again: memory from
/// 128 KiB on is mapped page by page, as it is needed, and most programs send no segments.
pub(crate) const SEGMENT_MAX: usize = 132 << 10;

/// Room for one frame, of either length.
pub(crate) type Frame = Box<[u8]>;

/// Filled, not only zeroed, so that its page is mapped when a packet needs it.
pub(crate) fn new_frame() -> Frame {
    vec![0x77; FRAME_MAX].into_boxed_slice()
}

/// The part that a packet needs is mapped.
pub(crate) fn new_segment() -> Frame {
    let mut segment = vec![0; SEGMENT_MAX];
    segment[..FRAME_MAX].fill(0x77);
    segment.into_boxed_slice()
}

/// Frames that are free.
#[derive(Debug, Default)]
pub(crate) struct Pool {
    frames: Vec<Frame>,
    segments: Vec<Frame>,
}

impl Pool {
    /// A pool with so many small frames.
    pub(crate) fn with_frames(count: usize) -> Self {
        let mut frames = Vec::with_capacity(count);
        frames.resize_with(count, new_frame);
        Self {
            frames,
            segments: Vec::new(),
        }
    }

    /// Room for so many bytes, at most [`SEGMENT_MAX`].
    pub(crate) fn take(&mut self, bytes: usize) -> Frame {
        if bytes <= FRAME_MAX {
            self.frames.pop().unwrap_or_else(new_frame)
        } else {
            self.segments.pop().unwrap_or_else(new_segment)
        }
    }

    /// Takes back a frame.
    pub(crate) fn put(&mut self, frame: Frame) {
        if frame.len() <= FRAME_MAX {
            self.frames.push(frame);
        } else {
            self.segments.push(frame);
        }
    }

    /// How many small frames are free.
    #[cfg(test)]
    pub(crate) fn frames(&self) -> usize {
        self.frames.len()
    }
}
