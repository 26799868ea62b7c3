//! The rate limit and its queue: the only part of a link that depends on the packets.
//!
//! A drop-tail queue in front of the wire, as at a router's slow output. It counts the packets that
//! wait or are being sent, not those on the wire (tc's netem counts these too).

use std::collections::VecDeque;

const NS_PER_S: u128 = 1_000_000_000;

/// The queue of one direction.
#[derive(Debug, Clone)]
pub(crate) struct Bottleneck {
    limit: usize,
    /// When each packet in the queue will have been sent.
    sent_ns: VecDeque<u64>,
}

impl Bottleneck {
    pub(crate) fn new(limit: u32) -> Self {
        Self {
            limit: limit as usize,
            sent_ns: VecDeque::new(),
        }
    }

    /// When a packet of `bytes` that comes at `t_ns` will have been sent, or `None` if `limit`
    /// packets are in the queue already. `rate_at` gives the rate in bit/s at an instant; a packet is
    /// sent at the rate of the instant when its sending starts.
    pub(crate) fn enter(
        &mut self,
        t_ns: u64,
        bytes: u32,
        rate_at: impl FnOnce(u64) -> u64,
    ) -> Option<u64> {
        while self.sent_ns.front().is_some_and(|&sent_ns| sent_ns <= t_ns) {
            self.sent_ns.pop_front();
        }
        if self.sent_ns.len() >= self.limit {
            return None;
        }
        let start_ns = self.sent_ns.back().copied().unwrap_or(t_ns);
        let sent_ns = start_ns.saturating_add(Self::takes_ns(bytes, rate_at(start_ns)));
        self.sent_ns.push_back(sent_ns);
        Some(sent_ns)
    }

    /// How long it takes to send `bytes` at `rate_bps`. Rounded up, so that the rate is an upper
    /// bound over any window.
    pub(crate) fn takes_ns(bytes: u32, rate_bps: u64) -> u64 {
        let takes_ns = (u128::from(bytes) * 8 * NS_PER_S).div_ceil(u128::from(rate_bps).max(1));
        u64::try_from(takes_ns).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_counts_the_packet_being_sent() {
        // 1250 bytes at 1 Mbit/s take 10 ms. With limit 2 the third packet of a burst is dropped, and
        // one that comes when the first has been sent fits.
        let mut queue = Bottleneck::new(2);
        let mut enter = |t_ms: u64| queue.enter(t_ms * 1_000_000, 1250, |_| 1_000_000);
        assert_eq!(enter(0), Some(10_000_000));
        assert_eq!(enter(0), Some(20_000_000));
        assert_eq!(enter(9), None);
        assert_eq!(enter(10), Some(30_000_000));
    }
}
