//! When a client's kernel acknowledges an answer: at once, by a timer, or with the next message.
//!
//! Linux treats a connection as interactive if it sent data soon after it had received some. It then
//! delays an acknowledgement until the next message, at most until a timer ends
//! (`inet_csk_in_pingpong_mode`). Otherwise the kernel acknowledges an answer as soon as the program
//! reads it (`tcp_cleanup_rbuf`). The plant counts the wait for this acknowledgement as part of the
//! round trip. Its own acknowledgements travel with its answers, which it sends at once.

use crate::retransmission::Wheel;

/// Shortest delayed-acknowledgement timer (`TCP_ATO_MIN`, `TCP_DELACK_MIN`).
const LEAST_NS: u64 = 40_000_000;

/// When an answer was acknowledged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Acknowledged {
    /// There was no answer yet.
    #[default]
    Never,
    /// This long after its arrival, in ns.
    After(u64),
    /// With the next message; the answer arrived at this time.
    WithMessage { answered_ns: u64 },
}

/// Acknowledgement state of one connection.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Acknowledger {
    /// When the last answer arrived.
    received_ns: Option<u64>,
    /// A message that follows an answer within this time makes the connection interactive; it also
    /// limits how long an acknowledgement waits for a message (`icsk_ack.ato`).
    patience_ns: u64,
    is_interactive: bool,
}

impl Acknowledger {
    /// Whether acknowledgements wait for the next message.
    pub(crate) fn is_interactive(&self) -> bool {
        self.is_interactive
    }

    /// Notes that an answer arrived (`tcp_event_data_recv`).
    #[inline]
    pub(crate) fn receives(&mut self, now_ns: u64) {
        let pause_ns = self.received_ns.map(|before_ns| now_ns - before_ns);
        self.patience_ns = match pause_ns {
            None => LEAST_NS,
            Some(pause_ns) if pause_ns <= LEAST_NS / 2 => self.patience_ns / 2 + LEAST_NS / 2,
            Some(pause_ns) if pause_ns < self.patience_ns => self.patience_ns / 2 + pause_ns,
            Some(_) => self.patience_ns,
        };
        self.received_ns = Some(now_ns);
    }

    /// Notes that a message is sent, with a smoothed round trip of `rtt_ns`. Returns when the answer
    /// before it was acknowledged (`tcp_send_delayed_ack`, `tcp_event_data_sent`).
    #[inline]
    pub(crate) fn sends(&mut self, now_ns: u64, rtt_ns: u64, wheel: Wheel) -> Acknowledged {
        let Some(answered_ns) = self.received_ns else {
            return Acknowledged::Never;
        };
        let wait_ns = self.patience_ns.min(rtt_ns.max(LEAST_NS));
        let acknowledged = if !self.is_interactive {
            Acknowledged::After(0)
        } else {
            match wheel.rung_ns(answered_ns, wait_ns, now_ns) {
                None => Acknowledged::WithMessage { answered_ns },
                Some(by_timer_ns) => {
                    // The acknowledgement waited in vain.
                    self.is_interactive = false;
                    self.patience_ns = LEAST_NS;
                    Acknowledged::After(by_timer_ns - answered_ns)
                }
            }
        };
        self.is_interactive |= now_ns - answered_ns < self.patience_ns;
        acknowledged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// How each answer is acknowledged if it comes 3 ms after its message and the next message
    /// follows after the given pauses in ms.
    fn acknowledged(pauses_ms: &[u64]) -> Vec<Acknowledged> {
        let mut acknowledger = Acknowledger::default();
        let mut now_ns = 1_000 * MS;
        let wheel = Wheel::new(250, 1);
        let mut all = Vec::new();
        for pause_ms in pauses_ms {
            now_ns += 3 * MS;
            acknowledger.receives(now_ns);
            now_ns += pause_ms * MS;
            all.push(acknowledger.sends(now_ns, 3 * MS, wheel));
        }
        all
    }

    #[test]
    fn who_sends_seldom_acknowledges_at_once() {
        assert_eq!(acknowledged(&[97; 5]), [Acknowledged::After(0); 5]);
    }

    #[test]
    fn who_sends_often_acknowledges_with_the_next_message() {
        let all = acknowledged(&[7; 5]);
        assert_eq!(all[0], Acknowledged::After(0));
        let with = |one: &Acknowledged| matches!(one, Acknowledged::WithMessage { .. });
        assert!(all[1..].iter().all(with), "{all:?}");
    }

    #[test]
    fn who_stops_sending_often_acknowledges_by_a_timer_once() {
        let all = acknowledged(&[7, 7, 97, 97]);
        let Acknowledged::After(pause_ns) = all[2] else {
            panic!("{all:?}");
        };
        assert!((40 * MS..=44 * MS).contains(&pause_ns), "{pause_ns}");
        assert_eq!(all[3], Acknowledged::After(0));
    }
}
