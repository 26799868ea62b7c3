//! The packets that entered one direction with a rate limit. They determine the queue, and so the
//! delay of a packet, at each instant in retrospect.
//!
//! The same [`Bottleneck`] that played the queue replays it. Recording the packets is the task of
//! others; the [`Path`](crate::Path) adds delay and loss behind the queue.

use crate::bottleneck::Bottleneck;
use crate::time::LinkTime;
use crate::way::Way;

text::row!(
    /// A packet that entered a link with a rate limit, whether it was lost or not: all of them together
    /// determine the queue in front of each. Rows of a way are in order of entry.
    #[derive(Eq)]
    PacketRow {
        /// When it entered the link, monotonic; never before link time 0.
        t_ns: u64,
        /// The way that it took: to the plant, or back.
        way: Way,
        /// Its length as an IP packet.
        bytes: u32,
    }
);

/// A packet that the queue accepted.
#[derive(Debug, Clone, Copy)]
struct Taken {
    t_ns: u64,
    sent_ns: u64,
}

/// The packets of one direction, in order of entry.
#[derive(Debug, Clone)]
pub struct Load {
    limit: usize,
    taken: Vec<Taken>,
    /// Time of entry and length of all packets, including those that found the queue full.
    entered: Vec<(u64, u32)>,
}

impl Load {
    /// The load from packets that entered at `(t_ns, bytes)`, in link time and IP length, in that order.
    pub(crate) fn new(
        limit: u32,
        rate_at: impl Fn(u64) -> u64,
        packets: impl IntoIterator<Item = (u64, u32)>,
    ) -> Load {
        let mut queue = Bottleneck::new(limit);
        let entered: Vec<(u64, u32)> = packets.into_iter().collect();
        let take = |&(t_ns, bytes): &(u64, u32)| {
            let sent_ns = queue.enter(t_ns, bytes, &rate_at)?;
            Some(Taken { t_ns, sent_ns })
        };
        Load {
            limit: limit as usize,
            taken: entered.iter().filter_map(take).collect(),
            entered,
        }
    }

    /// The length of the first packet of `at_least` bytes that entered from `t` to `within_ns` later.
    pub(crate) fn bytes(&self, t: LinkTime, within_ns: u64, at_least: u32) -> Option<u32> {
        let t_ns = t.ns();
        let from = self
            .entered
            .partition_point(|(entered_ns, _)| *entered_ns < t_ns);
        let last_ns = t_ns.saturating_add(within_ns);
        let mut inside = self.entered[from..]
            .iter()
            .take_while(|(t_ns, _)| *t_ns <= last_ns);
        inside
            .find(|(_, bytes)| *bytes >= at_least)
            .map(|(_, bytes)| *bytes)
    }

    /// When a packet of `bytes` that came at `t_ns`, ahead of those recorded at the same instant,
    /// would have been sent; `None` if the queue was full.
    pub(crate) fn sent_ns(
        &self,
        t_ns: u64,
        bytes: u32,
        rate_at: impl FnOnce(u64) -> u64,
    ) -> Option<u64> {
        let before = self.taken.partition_point(|taken| taken.t_ns < t_ns);
        let ahead = &self.taken[..before];
        let waiting = before - ahead.partition_point(|taken| taken.sent_ns <= t_ns);
        if waiting >= self.limit {
            return None;
        }
        let start_ns = ahead.last().map_or(t_ns, |last| last.sent_ns.max(t_ns));
        let takes_ns = Bottleneck::takes_ns(bytes, rate_at(start_ns));
        Some(start_ns.saturating_add(takes_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_packet_waits_for_those_before_it_and_finds_a_full_queue() {
        // 1250 bytes at 1 Mbit/s take 10 ms: two at 0 are sent at 10 and 20 ms.
        let rate = |_| 1_000_000;
        let ms = 1_000_000;
        let load = Load::new(2, rate, [(0, 1250), (0, 1250)]);
        assert_eq!(load.sent_ns(0, 125, rate), Some(ms));
        assert_eq!(load.sent_ns(5 * ms, 125, rate), None);
        assert_eq!(load.sent_ns(12 * ms, 125, rate), Some(21 * ms));
        assert_eq!(load.sent_ns(50 * ms, 125, rate), Some(51 * ms));
    }

    proptest! {
        /// A recorded packet is sent at the same time as one of its length that came just before it.
        #[test]
        fn what_was_played_is_what_is_told(
            gaps_us in prop::collection::vec((1_u64..3_000, 40_u32..1500), 1..200),
            limit in 1_u32..20,
        ) {
            let rate = |_| 2_000_000;
            let mut t_ns = 0;
            let packets: Vec<_> = gaps_us.iter().map(|&(gap_us, bytes)| {
                t_ns += gap_us * 1_000;
                (t_ns, bytes)
            }).collect();
            let mut queue = Bottleneck::new(limit);
            let load = Load::new(limit, rate, packets.iter().copied());
            for &(t_ns, bytes) in &packets {
                prop_assert_eq!(load.sent_ns(t_ns, bytes, rate), queue.enter(t_ns, bytes, rate));
            }
        }
    }
}
