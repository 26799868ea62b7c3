//! When a client's kernel acknowledges an answer: at once, by a timer, or with the next message.
//!
//! Linux takes a connection for interactive on which it sent something soon after it received
//! something, and then leaves the acknowledgement of what comes to the next message, for as long as
//! a timer goes (`inet_csk_in_pingpong_mode`). Otherwise a program that reads an answer has it
//! acknowledged at once (`tcp_cleanup_rbuf`). The plant takes the time to it for a round trip. Its
//! own acknowledgements go with its answers, which come at once.

use crate::retransmission::Wheel;

/// The least that the timer is set for (`TCP_ATO_MIN`, `TCP_DELACK_MIN`).
const LEAST_NS: u64 = 40_000_000;

/// When an answer was acknowledged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Acknowledged {
    /// There was none yet.
    #[default]
    Never,
    /// This long after its arrival, in ns.
    After(u64),
    /// With the next message; it was there at this time.
    WithMessage { answered_ns: u64 },
}

/// One connection's ways.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Acknowledger {
    /// When the last answer was there.
    received_ns: Option<u64>,
    /// How soon a message has to follow an answer to make the connection interactive, and how long
    /// its acknowledgement may wait for one (`icsk_ack.ato`).
    patience_ns: u64,
    is_interactive: bool,
}

impl Acknowledger {
    /// Whether the next message is waited for.
    pub(crate) fn is_interactive(&self) -> bool {
        self.is_interactive
    }

    /// An answer is there (`tcp_event_data_recv`).
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

    /// A message is sent, with a smoothed round trip of `rtt_ns`: when the answer before it was
    /// acknowledged (`tcp_send_delayed_ack`, `tcp_event_data_sent`).
    pub(crate) fn sends(&mut self, now_ns: u64, rtt_ns: u64, wheel: Wheel) -> Acknowledged {
        let Some(answered_ns) = self.received_ns else {
            return Acknowledged::Never;
        };
        let by_timer_ns = wheel.rings_ns(answered_ns, self.patience_ns.min(rtt_ns.max(LEAST_NS)));
        let acknowledged = match self.is_interactive {
            false => Acknowledged::After(0),
            true if by_timer_ns > now_ns => Acknowledged::WithMessage { answered_ns },
            true => {
                // It waited in vain.
                self.is_interactive = false;
                self.patience_ns = LEAST_NS;
                Acknowledged::After(by_timer_ns - answered_ns)
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

    /// Answers that come 3 ms after each message, and messages so many ms after each answer: when
    /// each answer was acknowledged.
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
