//! What a client may take of a message's time: the limits of a verdict that are a client's own.

/// What a client and the kernels take of a message's time beside the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// From the stamp of sending to the first packet's entry into the link, at most as a rule, ms: in
    /// this window the link's state counts.
    pub enters_within_ms: f64,
    /// Likewise, at the very most: a loss in this window excuses a message that came late. Between stamp
    /// and sending an interpreter's thread may lose its turn for 5 ms, twice, and any thread its
    /// processor.
    pub strays_within_ms: f64,
    /// What nine of ten messages need on the way up beyond the link, at most, ms.
    pub up_floor_ms: f64,
    /// Likewise on the way down: the plant's answer, the client's reading.
    pub down_floor_ms: f64,
    /// What an answer takes the client when hundreds are there at once, at most, ms. Python's threads took
    /// 0.6 each for the 600 of a stall of 1.9 s at 333 Hz.
    pub message_ms: f64,
    /// How far the client's clock may be from the plant's, ms: what it adds to one way it takes off the
    /// other. A page's is the wall clock of when the page began.
    pub clock_ms: f64,
    /// Whether a deadline that is missed says something of the machine. Where the client is an
    /// interpreter or a page it may be the client's own doing; then only the kernel's word counts.
    pub keeps_time: bool,
}
