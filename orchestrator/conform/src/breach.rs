//! What a controller did that the contract does not allow, with the numbers and what to do about it.

use endpoint::{Mode, SampleTime};

/// A breach of the contract.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Breach {
    /// No message came.
    #[error("no message reached the plant; send GET /{mode}?u=0.35 to WEBLOOP_PLANT each h")]
    Silent {
        /// The mode that it was told.
        mode: Mode,
    },
    /// A message came before the start, by more than h.
    #[error(
        "the first message came {before_ms:.1} ms before the start, more than h ({h}); wait until \
         WEBLOOP_START_NS"
    )]
    Early {
        /// How long before the start, ms.
        before_ms: f64,
        /// The sample time.
        h: SampleTime,
    },
    /// Too few messages came.
    #[error(
        "{sent} messages came and {due} were due, the first {first_s:.2} s after the start; send one \
         each h ({h}), at start + k h"
    )]
    Slow {
        /// Number of messages.
        sent: u64,
        /// Number of messages that were due.
        due: u64,
        /// When the first came, s after the start.
        first_s: f64,
        /// The sample time.
        h: SampleTime,
    },
    /// Too many messages came.
    #[error(
        "{sent} messages came, {due} were due and at most {most} are accepted; send one each h, and \
         none again for what is past"
    )]
    Flood {
        /// Number of messages.
        sent: u64,
        /// Number of messages that were due.
        due: u64,
        /// Greatest number that is accepted.
        most: u64,
    },
    /// Requests came that a plant refuses.
    #[error("{count} requests are refused by any plant, the first because: {first}")]
    Refused {
        /// Number of these requests.
        count: u64,
        /// Why the first was refused.
        first: String,
    },
    /// Messages went to the other mode's path.
    #[error("{count} messages went to /{other} though WEBLOOP_MODE is `{told}`; send to /{told}")]
    OtherMode {
        /// Number of these messages.
        count: u64,
        /// The mode of their path.
        other: Mode,
        /// The mode that it was told.
        told: Mode,
    },
    /// seq did not begin at 0.
    #[error("the first message has seq {seq}; count the messages from 0, or leave seq out")]
    FirstSeq {
        /// Its seq.
        seq: u64,
    },
    /// Two messages had the same seq.
    #[error("seq {seq} came twice; give each message its own number, or leave seq out")]
    RepeatedSeq {
        /// The seq.
        seq: u64,
    },
    /// seq fell within a connection.
    #[error("seq {seq} came after {after} on one connection; count upwards, or leave seq out")]
    FallingSeq {
        /// The seq.
        seq: u64,
        /// The one before.
        after: u64,
    },
    /// A message says that it was sent after it had arrived.
    #[error(
        "a message arrived {ahead_ms:.1} ms before its t_send_ns; give CLOCK_MONOTONIC in ns, or leave \
         it out"
    )]
    SentLater {
        /// By how much, ms.
        ahead_ms: f64,
    },
    /// A message says that it was sent long before it arrived.
    #[error(
        "a message arrived {before_s:.1} s after its t_send_ns, without a link; give CLOCK_MONOTONIC \
         in ns at the time of sending, or leave it out"
    )]
    SentLongBefore {
        /// By how much, s.
        before_s: f64,
    },
    /// It opened too many connections.
    #[error(
        "{connections} connections for {messages} messages, at most {most} are accepted; keep a \
         connection for the next message"
    )]
    Connections {
        /// Number of connections.
        connections: u64,
        /// Number of messages.
        messages: u64,
        /// Greatest number of connections that is accepted.
        most: u64,
    },
    /// No message came after a disturbance.
    #[error(
        "no message came within 1 s after {event}, {at_s:.1} s after the start; go on after a late or \
         missing answer, on a new connection if necessary"
    )]
    Quiet {
        /// The end of the disturbance.
        event: &'static str,
        /// When it was, s after the start.
        at_s: f64,
    },
    /// It does not support a closed loop.
    #[error(
        "it ended with exit code 127, so it does not support what it is told; a shell has this code \
         for a command that it does not find"
    )]
    Unsupported,
    /// It did not end well.
    #[error("{words}")]
    Failed {
        /// How it ended, and its last words.
        words: String,
    },
    /// It ended before its time.
    #[error(
        "it ended {before_s:.2} s before its time; go on until WEBLOOP_DURATION_S after \
         WEBLOOP_START"
    )]
    EndedEarly {
        /// How long before, s.
        before_s: f64,
    },
    /// It did not end by itself.
    #[error(
        "it still ran {within_s:.1} s after its time; end by yourself, with exit code 0, when \
         WEBLOOP_DURATION_S is over"
    )]
    RanOn {
        /// How long after its time it still ran, s.
        within_s: f64,
    },
    /// It did not end on SIGTERM.
    #[error("it did not end within 1 s of SIGTERM and was killed; let SIGTERM end it")]
    IgnoredTerm,
}
