//! A message of a run as blame sees it, and a deadline at which one was due. What made messages late is in
//! [`traffic`](super::traffic).

use super::Cause;

/// A message that was sent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Message {
    pub(super) seq: u64,
    pub(super) due_ns: u64,
    pub(super) send_ns: u64,
    /// Whether the time of sending is not the controller's own stamp.
    pub(super) is_guessed: bool,
    pub(super) arrive_ns: Option<u64>,
    /// Whether the plant took it.
    pub(super) is_taken: bool,
    pub(super) receive_ns: Option<u64>,
    /// The plant's tick whose y the answer has.
    pub(super) tick: Option<u64>,
    /// The link's shares of both ways.
    pub(super) up_ns: u64,
    pub(super) down_ns: u64,
    /// What the rest of each way is due to.
    pub(super) up_late: Cause,
    pub(super) down_late: Cause,
}

impl Message {
    /// When nothing waits for it any more.
    pub(super) fn over_ns(&self, timeout_ns: u64) -> u64 {
        self.receive_ns
            .unwrap_or_else(|| self.send_ns.saturating_add(timeout_ns))
    }

    /// How much later than the link allows it came, ns.
    pub(super) fn up_late_ns(&self) -> u64 {
        let arrive_ns = self.arrive_ns.unwrap_or(self.send_ns);
        arrive_ns.saturating_sub(self.send_ns.saturating_add(self.up_ns))
    }

    /// The same of its answer, ns.
    pub(super) fn down_late_ns(&self) -> u64 {
        let from_ns = self.arrive_ns.unwrap_or(self.send_ns);
        let receive_ns = self.receive_ns.unwrap_or(from_ns);
        receive_ns.saturating_sub(from_ns.saturating_add(self.down_ns))
    }
}

/// A deadline, and the message that was sent for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deadline {
    pub(super) due_ns: u64,
    /// Its place among the messages; `None` if nothing was sent.
    pub(super) message: Option<usize>,
}
