//! When TCP sends a lost packet again: the timers of RFC 6298 and RFC 8985 as Linux has them.
//!
//! A message is one packet and alone on its connection, so nothing after it tells of its loss:
//! only timers do. The first to end is the tail loss probe, which with one packet under way is
//! due when the retransmission timeout is; it sends the packet again and does not double the
//! timeout. Each that follows does.

/// Linux's least retransmission timeout beyond the round trip (`TCP_RTO_MIN`).
const VARIATION_MIN_NS: u64 = 200_000_000;
/// The timeout before any round trip was seen (RFC 6298, 2.1).
pub(crate) const INITIAL_NS: u64 = 1_000_000_000;
/// The greatest timeout (`TCP_RTO_MAX`).
const GREATEST_NS: u64 = 120_000_000_000;

/// One end's estimate of its round trip, in ns: RFC 6298 as Linux has it (`tcp_rtt_estimator`).
///
/// Other than the RFC's, its variation hardly grows when round trips become shorter, and falls
/// back slowly from the greatest that there was: a stall that is over is not mistaken for another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RoundTrip {
    smoothed_ns: u64,
    /// Four mean deviations.
    deviation_ns: u64,
    /// What is waited beyond the smoothed round trip.
    variation_ns: u64,
}

impl RoundTrip {
    /// From the first round trip, a handshake's.
    pub(crate) fn first(rtt_ns: u64) -> Self {
        Self {
            smoothed_ns: rtt_ns,
            deviation_ns: 2 * rtt_ns,
            variation_ns: (2 * rtt_ns).max(VARIATION_MIN_NS),
        }
    }

    /// Takes in a round trip. One whose packet was sent twice must not be (Karn's algorithm).
    pub(crate) fn seen(&mut self, rtt_ns: u64) {
        let quarter_ns = self.deviation_ns / 4;
        let off_ns = rtt_ns.abs_diff(self.smoothed_ns);
        let growth_ns = match off_ns.checked_sub(quarter_ns) {
            Some(more_ns) if rtt_ns < self.smoothed_ns => more_ns / 8,
            Some(more_ns) => more_ns,
            None => 0,
        };
        self.deviation_ns = self.deviation_ns + growth_ns - quarter_ns.saturating_sub(off_ns);
        self.smoothed_ns = self.smoothed_ns - self.smoothed_ns / 8 + rtt_ns / 8;
        let least_ns = self.deviation_ns.max(VARIATION_MIN_NS);
        self.variation_ns = match self.variation_ns.checked_sub(least_ns) {
            Some(beyond_ns) => self.variation_ns - beyond_ns / 4,
            None => least_ns,
        };
    }

    /// The smoothed round trip.
    pub(crate) fn smoothed_ns(&self) -> u64 {
        self.smoothed_ns
    }

    /// How long to wait for an acknowledgement.
    pub(crate) fn timeout_ns(&self) -> u64 {
        (self.smoothed_ns + self.variation_ns).min(GREATEST_NS)
    }
}

/// How long after the `tries`-th sending of a packet the next comes: once the timeout, once more,
/// then twice that, and so on.
pub(crate) fn pause_ns(timeout_ns: u64, tries: u16) -> u64 {
    let doublings = tries.saturating_sub(2).min(32);
    timeout_ns
        .saturating_mul(1_u64 << doublings)
        .min(GREATEST_NS)
}

/// The same for the packets of a handshake, which has no probe.
pub(crate) fn handshake_pause_ns(tries: u16) -> u64 {
    let doublings = tries.saturating_sub(1).min(32);
    INITIAL_NS
        .saturating_mul(1_u64 << doublings)
        .min(GREATEST_NS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_round_trip_waits_for_itself_and_200_ms() {
        let mut round_trip = RoundTrip::first(50_000_000);
        for _ in 0..100 {
            round_trip.seen(50_000_000);
        }
        let timeout_ms = round_trip.timeout_ns() / 1_000_000;
        assert!((249..=250).contains(&timeout_ms), "{timeout_ms}");
    }

    #[test]
    fn a_stall_that_is_over_is_forgotten_within_some_round_trips() {
        let mut round_trip = RoundTrip::first(10_000_000);
        round_trip.seen(1_000_000_000);
        let after_ns = round_trip.timeout_ns();
        assert!(after_ns > 900_000_000, "{after_ns}");
        for _ in 0..30 {
            round_trip.seen(10_000_000);
            assert!(round_trip.timeout_ns() <= after_ns);
        }
        assert!(round_trip.timeout_ns() < 400_000_000, "{round_trip:?}");
    }

    #[test]
    fn a_packet_is_sent_again_after_one_two_four_and_eight_timeouts() {
        let mut t_ns = 0;
        let times: Vec<u64> = (1..=4)
            .map(|tries| {
                t_ns += pause_ns(200, tries);
                t_ns
            })
            .collect();
        assert_eq!(times, [200, 400, 800, 1600]);
        assert_eq!(handshake_pause_ns(1), INITIAL_NS);
        assert_eq!(handshake_pause_ns(3), 4 * INITIAL_NS);
    }
}
