//! What the controller's rows say (`messages.csv`): deadlines, what became of them, round trips.

use endpoint::{MessageOutcome, MessageRow};
use serde::{Deserialize, Serialize};

use crate::statistics::{Quantiles, ms};

/// The controller's deadlines and messages. Every deadline is one of the four outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Messages {
    /// Deadlines.
    pub due: u64,
    /// Messages sent.
    pub sent: u64,
    /// Messages that were answered.
    pub answered: u64,
    /// Messages without an answer in time.
    pub timeout: u64,
    /// Messages whose connection or answer was broken.
    pub failed: u64,
    /// Deadlines without a message.
    pub missed: u64,
    /// The least round trip of the answered ones, ms.
    pub rtt_min_ms: Option<f64>,
    /// Their round trips, from sending to having the answer.
    pub rtt: Quantiles,
}

/// Messages under way.
#[derive(Debug, Default)]
pub(crate) struct MessageCount {
    due: u64,
    sent: u64,
    answered: u64,
    timeout: u64,
    failed: u64,
    missed: u64,
    rtt_ns: Vec<u64>,
}

impl MessageCount {
    pub(crate) fn push(&mut self, row: &MessageRow) {
        self.due += 1;
        self.sent += u64::from(row.t_send_ns.is_some());
        *match row.outcome {
            MessageOutcome::Answered => &mut self.answered,
            MessageOutcome::Timeout => &mut self.timeout,
            MessageOutcome::Failed => &mut self.failed,
            MessageOutcome::Missed => &mut self.missed,
        } += 1;
        if let (Some(sent_ns), Some(received_ns)) = (row.t_send_ns, row.t_receive_ns) {
            self.rtt_ns.push(received_ns.saturating_sub(sent_ns));
        }
    }

    pub(crate) fn finish(self) -> Messages {
        let Self {
            due,
            sent,
            answered,
            timeout,
            failed,
            missed,
            rtt_ns,
        } = self;
        Messages {
            due,
            sent,
            answered,
            timeout,
            failed,
            missed,
            rtt_min_ms: rtt_ns.iter().min().copied().map(ms),
            rtt: Quantiles::of(rtt_ns),
        }
    }
}
