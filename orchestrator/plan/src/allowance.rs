//! How much of a message's time a client may take: the limits of a verdict that depend on the client.

/// Steps of a client's tail.
pub const TAILS: usize = 2;

/// How many messages may be late by so much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tail {
    /// Later than the quickest tenth by more than this, ms.
    pub beyond_ms: f64,
    /// Share of messages, 0 to 1.
    pub share: f64,
}

/// How much time a client and the kernels may add to a message's time on the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Longest usual time from the send stamp until the first packet enters the link, ms. The state of
    /// the link in this window counts.
    pub enters_within_ms: f64,
    /// Longest possible time for the same, ms: a loss in this window excuses a message that came late.
    /// Between the stamp and the sending, an interpreter's thread may lose its turn for 5 ms, twice,
    /// and any thread its processor.
    pub strays_within_ms: f64,
    /// Share of messages, 0 to 1, that may be late without a loss on the link as an excuse. On a quiet
    /// machine none is late; a machine that loses one packet in a hundred outside the link makes two in a
    /// hundred late, and those of a page show as resent anyway. A page's engine tidies up when
    /// it likes: at 100 Hz, alone on a quiet machine of two cores, it held up 0.6 and 0.7 % of Firefox's
    /// messages by more than 10 ms.
    pub late_share: f64,
    /// If nine of ten messages take more than this on the way up in addition to the link, ms, something
    /// else delays them.
    pub up_floor_ms: f64,
    /// The same on the way down: the plant's answer and the client's reading, ms.
    pub down_floor_ms: f64,
    /// Longest time that it takes in addition to open a connection for a message, ms: a socket, an accepted one, and
    /// the plant's task for it.
    pub opening_ms: f64,
    /// How many messages may be later than the quickest tenth by more than each of these times, on either way: a
    /// scheduler's slices, an interpreter's turns, a page's other tasks. On a quiet machine a third of these shares is
    /// not reached; more is done to the messages.
    pub tail: [Tail; TAILS],
    /// Longest time that the client needs for an answer when hundreds arrive at once, ms. Python's
    /// threads took 0.6 ms for each of the 600 answers after a stall of 1.9 s at 333 Hz.
    pub message_ms: f64,
    /// Largest difference between the client's clock and the plant's, ms: what it adds to one way, it
    /// takes off the other. A page uses the wall clock as it was when the page began.
    pub clock_ms: f64,
    /// Whether a missed deadline is evidence about the machine. An interpreter or a page may miss one
    /// by itself; for those, only what the kernel reports counts.
    pub keeps_time: bool,
}
