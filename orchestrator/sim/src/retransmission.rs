//! When TCP sends a lost packet again: the timers of RFC 6298 and RFC 8985 as implemented in Linux
//! 6.5 to 6.18, on the kernel's timer wheel.
//!
//! A message is one packet and alone on its connection, so no later packet reveals its loss, only
//! timers do. The first is the tail loss probe. With one packet under way it is due after two round
//! trips plus 200 ms, or with the retransmission timeout if that is earlier; it sends the packet
//! again and does not double the timeout. Every later timer doubles it (`tcp_schedule_loss_probe`,
//! `tcp_retransmit_timer`).

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Least time that Linux adds to the round trip in its retransmission timeout (`TCP_RTO_MIN`).
pub(crate) const VARIATION_MIN_NS: u64 = 200_000_000;
/// The timeout before any round trip was measured (RFC 6298, 2.1).
pub(crate) const INITIAL_NS: u64 = 1_000_000_000;
/// The greatest timeout (`TCP_RTO_MAX`).
const GREATEST_NS: u64 = 120_000_000_000;
/// Number of SYNs resent before the timeout doubles (`tcp_syn_linear_timeouts`).
const LINEAR_SYNS: u16 = 4;

/// Linux's timer wheel since 4.8 (`calc_wheel_index` in `kernel/time/timer.c`): a timer ends at a
/// tick (a jiffy) after its time; the longer the timer, the coarser the ticks.
///
/// A timer of less than 63 jiffies ends at the first tick after its last jiffy, one of less than 8 *
/// 63 at the first such tick that is a multiple of 8, and so on in powers of 8. A timer is never
/// early. At 250 ticks a second, 203 ms become 204 to 208 ms, and 253 ms become 256 to 288 ms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wheel {
    jiffy_ns: u64,
    /// How long the machine had run at virtual time 0.
    ahead_ns: u64,
}

impl Wheel {
    /// The wheel of a kernel with `hz` ticks a second. The seed chooses the phase of the ticks,
    /// because a run is not synchronous with them.
    pub(crate) fn new(hz: u32, seed: u64) -> Self {
        let jiffy_ns = (1_000_000_000 / u64::from(hz.max(1))).max(1);
        // A random stream other than the run's own and the plant's phase; an uptime of at most a day.
        let mut random = ChaCha8Rng::seed_from_u64(seed.rotate_left(32) ^ 0x7769_6d65_7273);
        Self {
            jiffy_ns,
            ahead_ns: random.next_u64() % 86_400_000_000_000,
        }
    }

    /// When a timer ends that was set at `now_ns` for `pause_ns`.
    pub(crate) fn rings_ns(self, now_ns: u64, pause_ns: u64) -> u64 {
        let jiffies = pause_ns.div_ceil(self.jiffy_ns);
        let expires = (now_ns + self.ahead_ns) / self.jiffy_ns + jiffies;
        let mut shift = 0;
        while shift < 24 && jiffies >= 63 << shift {
            shift += 3;
        }
        let rings = ((expires >> shift) + 1) << shift;
        rings * self.jiffy_ns - self.ahead_ns
    }

    /// When a timer ended that was set at `set_ns` for `pause_ns`; `None` if it has not at `now_ns`.
    #[inline]
    pub(crate) fn rung_ns(self, set_ns: u64, pause_ns: u64, now_ns: u64) -> Option<u64> {
        // No timer is early, so for most there is no need to look at the wheel, which costs two divisions.
        if set_ns + pause_ns >= now_ns {
            return None;
        }
        Some(self.rings_ns(set_ns, pause_ns)).filter(|rings_ns| *rings_ns <= now_ns)
    }
}

/// One end's estimate of its round trip, in ns: RFC 6298 as Linux implements it
/// (`tcp_rtt_estimator`).
///
/// Unlike the RFC's, its variation hardly grows when round trips become shorter, and decays slowly
/// from its maximum, so that the end of a stall is not mistaken for another stall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RoundTrip {
    smoothed_ns: u64,
    /// Four mean deviations.
    deviation_ns: u64,
    /// What the timeout adds to the smoothed round trip.
    variation_ns: u64,
}

impl RoundTrip {
    /// The estimate after the first round trip, a handshake's.
    pub(crate) fn first(rtt_ns: u64) -> Self {
        Self {
            smoothed_ns: rtt_ns,
            deviation_ns: 2 * rtt_ns,
            variation_ns: (2 * rtt_ns).max(VARIATION_MIN_NS),
        }
    }

    /// Updates the estimate with a round trip. Its packet must not have been sent twice (Karn's algorithm).
    #[inline]
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

    /// How long to wait before the tail loss probe.
    pub(crate) fn probe_ns(&self) -> u64 {
        (2 * self.smoothed_ns + VARIATION_MIN_NS).min(self.timeout_ns())
    }

    /// How long to wait for an acknowledgement.
    pub(crate) fn timeout_ns(&self) -> u64 {
        (self.smoothed_ns + self.variation_ns).min(GREATEST_NS)
    }
}

/// The pause between the `tries`-th sending of a packet and the next: the probe's, then the timeout,
/// then twice the timeout, and so on.
pub(crate) fn pause_ns(round_trip: RoundTrip, tries: u16) -> u64 {
    let timeout_ns = round_trip.timeout_ns();
    if tries == 1 {
        return round_trip.probe_ns();
    }
    let doublings = tries.saturating_sub(2).min(32);
    timeout_ns
        .saturating_mul(1_u64 << doublings)
        .min(GREATEST_NS)
}

/// The same for a SYN or SYN-ACK: a handshake has no probe.
pub(crate) fn handshake_pause_ns(is_syn: bool, tries: u16) -> u64 {
    let linear = if is_syn { LINEAR_SYNS } else { 0 };
    let doublings = tries.saturating_sub(1 + linear).min(32);
    INITIAL_NS
        .saturating_mul(1_u64 << doublings)
        .min(GREATEST_NS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
        // A round trip of 10 ms: its timeout is 210 ms, and a probe would be due after 220.
        let round_trip = RoundTrip::first(10_000_000);
        let times: Vec<u64> = (1..=4)
            .map(|tries| {
                t_ns += pause_ns(round_trip, tries);
                t_ns / 1_000_000
            })
            .collect();
        assert_eq!(times, [210, 420, 840, 1680]);
    }

    #[test]
    fn a_probe_does_not_wait_for_a_timeout_that_a_stall_has_made_long() {
        let mut round_trip = RoundTrip::first(10_000_000);
        round_trip.seen(1_000_000_000);
        // Smoothed: 10 - 10 / 8 + 1000 / 8 ms.
        assert_eq!(round_trip.smoothed_ns(), 133_750_000);
        assert_eq!(pause_ns(round_trip, 1), 467_500_000);
        assert_eq!(pause_ns(round_trip, 2), round_trip.timeout_ns());
        assert!(round_trip.timeout_ns() > 900_000_000);
    }

    #[test]
    fn four_syns_more_come_a_second_apart_and_what_answers_them_backs_off_at_once() {
        let pauses_s =
            |is_syn| [1, 2, 5, 6, 7].map(|tries| handshake_pause_ns(is_syn, tries) / INITIAL_NS);
        assert_eq!(pauses_s(true), [1, 1, 1, 2, 4]);
        assert_eq!(pauses_s(false), [1, 2, 16, 32, 64]);
    }

    #[test]
    fn a_timer_ends_with_the_tick_beyond_its_last_jiffy() {
        let wheel = Wheel {
            jiffy_ns: 4_000_000,
            ahead_ns: 0,
        };
        let rings_ms = |now_ms: u64, pause_us: u64| {
            wheel.rings_ns(now_ms * 1_000_000, pause_us * 1_000) / 1_000_000
        };
        // 203 ms are 51 jiffies. A timer set at a tick and one set just before the next end at the same tick.
        assert_eq!([rings_ms(400, 203_000), rings_ms(403, 203_000)], [608, 608]);
        assert_eq!(rings_ms(404, 203_000), 612);
        // 248.001 ms are 63 jiffies, so multiples of 8: set at jiffies 100 and 101 the timer is due
        // at ticks 164 and 165 and ends at 168; set at 105 it is due at 169 and ends at 176.
        assert_eq!([rings_ms(400, 248_000), rings_ms(400, 248_001)], [652, 672]);
        assert_eq!([rings_ms(404, 248_001), rings_ms(420, 248_001)], [672, 704]);
        // A second is 250 jiffies, so multiples of 8 too: 351 becomes 352.
        assert_eq!(rings_ms(400, 1_000_000), 1_408);
        // Three seconds are 750 jiffies, more than 8 * 63, so multiples of 64: 851 becomes 896.
        assert_eq!(rings_ms(400, 3_000_000), 3_584);
    }

    proptest! {
        #[test]
        fn no_timer_is_early_and_none_an_eighth_and_two_ticks_late(
            hz in prop::sample::select(vec![100_u32, 250, 300, 1000]),
            seed in any::<u64>(),
            now_ns in 0_u64..1_000_000_000_000,
            pause_ns in 1_u64..120_000_000_000,
        ) {
            let wheel = Wheel::new(hz, seed);
            let rings_ns = wheel.rings_ns(now_ns, pause_ns);
            prop_assert_eq!(wheel.rung_ns(now_ns, pause_ns, rings_ns), Some(rings_ns));
            prop_assert_eq!(wheel.rung_ns(now_ns, pause_ns, rings_ns - 1), None);
            let late_ns = rings_ns - now_ns - pause_ns;
            let jiffy_ns = 1_000_000_000 / u64::from(hz);
            prop_assert!(late_ns <= pause_ns.div_ceil(jiffy_ns) * jiffy_ns / 7 + 2 * jiffy_ns, "{late_ns}");
        }
    }
}
