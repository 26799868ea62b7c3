//! Metrics of the controller's rows (`messages.csv`): deadlines, their outcomes, round trips.

use endpoint::{MessageOutcome, MessageRow};
use serde::{Deserialize, Serialize};

use crate::statistics::{Quantiles, ms};

/// The controller's deadlines and messages. Every deadline has one outcome. Of a controller of somebody's
/// own only the messages that arrived are known, and those that did not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
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
    /// Shortest round trip of the answered messages, ms.
    pub rtt_min_ms: Option<f64>,
    /// Round trips of the messages, from sending to receiving the answer. Those without one, by a time-out or a broken
    /// connection, are later than all others; those whose fate nobody told are left out.
    pub rtt: Quantiles,
}

/// Accumulates [`Messages`] row by row.
#[derive(Debug, Default)]
pub(crate) struct MessageCount {
    messages: Messages,
    rtt_ns: Vec<u64>,
}

impl MessageCount {
    pub(crate) fn push(&mut self, row: &MessageRow) {
        let messages = &mut self.messages;
        messages.due += 1;
        messages.sent += u64::from(row.outcome != MessageOutcome::Missed);
        match row.outcome {
            MessageOutcome::Answered => messages.answered += 1,
            MessageOutcome::Timeout => messages.timeout += 1,
            MessageOutcome::Failed => messages.failed += 1,
            MessageOutcome::Missed => messages.missed += 1,
            MessageOutcome::Arrived => {}
        }
        let has_answer = !matches!(
            row.outcome,
            MessageOutcome::Timeout | MessageOutcome::Failed
        );
        let times = row.t_send_ns.zip(row.t_receive_ns);
        if let Some((sent_ns, received_ns)) = times.filter(|_| has_answer) {
            self.rtt_ns.push(received_ns.saturating_sub(sent_ns));
        }
    }

    pub(crate) fn finish(self) -> Messages {
        Messages {
            rtt_min_ms: self.rtt_ns.iter().min().copied().map(ms),
            rtt: Quantiles::with_missing(self.rtt_ns, self.messages.timeout + self.messages.failed),
            ..self.messages
        }
    }
}
