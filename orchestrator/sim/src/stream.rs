//! All messages on one connection, as a WebSocket carries them: a lost message holds up those behind it.
//!
//! Packets sent after a lost one reveal the loss. The packet is then sent again about a round trip
//! later, before any timer ends (RACK, RFC 8985): as soon as the next packet is acknowledged and a
//! quarter of the shortest round trip has passed beyond its own. A client that waits for each answer
//! sends no next packet, so the timer remains. The model leaves out slow start, with ten packets
//! under way, which lengthens a connection's first round trips over a long link; and that messages
//! which wait for it are sent together.

use std::collections::VecDeque;

use link::{PerWay, Way};

use crate::connection::Id;
use crate::retransmission::{VARIATION_MIN_NS, Wheel};

/// The two ways of one connection.
#[derive(Debug)]
pub(crate) struct Stream {
    lines: PerWay<Line>,
    /// Time from one packet to the next; `None` if the client waits for each answer.
    pause_ns: Option<u64>,
}

/// One way: messages sent and not yet read, in the order of sending.
#[derive(Debug, Default)]
struct Line {
    waiting: VecDeque<Waiting>,
    /// How long the latest packet took, which RACK uses.
    delay_ns: u64,
    /// How long the fastest packet took.
    least_ns: Option<u64>,
}

#[derive(Debug, Clone, Copy)]
struct Waiting {
    id: Id,
    has_arrived: bool,
}

impl Stream {
    /// A connection that a packet enters every `pause_ns`; with `None`, only after the last was answered.
    pub(crate) fn new(pause_ns: Option<u64>) -> Self {
        Self {
            lines: PerWay::default(),
            pause_ns,
        }
    }

    /// A message enters one way, for the first time or again; `delay_ns` is how long its packet
    /// takes, `None` if it is lost. Marked cold, since most runs have no stream.
    #[cold]
    pub(crate) fn sends(&mut self, way: Way, id: Id, is_first: bool, delay_ns: Option<u64>) {
        let line = &mut self.lines[way];
        if is_first {
            line.waiting.push_back(Waiting {
                id,
                has_arrived: false,
            });
        }
        let Some(delay_ns) = delay_ns else {
            return;
        };
        line.delay_ns = delay_ns;
        line.least_ns = Some(line.least_ns.map_or(delay_ns, |least| least.min(delay_ns)));
    }

    /// A message has arrived.
    pub(crate) fn arrives(&mut self, way: Way, id: Id) {
        let waiting = self.lines[way].waiting.iter_mut();
        if let Some(place) = waiting.into_iter().find(|place| place.id == id) {
            place.has_arrived = true;
        }
    }

    /// Takes the next message that can be read: none while an earlier one is missing.
    pub(crate) fn reads(&mut self, way: Way) -> Option<Id> {
        let line = &mut self.lines[way];
        match line.waiting.front() {
            Some(first) if first.has_arrived => line.waiting.pop_front().map(|first| first.id),
            _ => None,
        }
    }

    /// When a packet that was sent at `now_ns` and lost is sent again.
    pub(crate) fn again_ns(&self, now_ns: u64, wheel: Wheel) -> u64 {
        let PerWay { up, down } = &self.lines;
        let rtt_ns = up.delay_ns + down.delay_ns;
        let least_ns = up.least_ns.unwrap_or(0) + down.least_ns.unwrap_or(0);
        let by_timer_ns = wheel.rings_ns(now_ns, rtt_ns + VARIATION_MIN_NS);
        match self.pause_ns {
            Some(pause_ns) => (now_ns + rtt_ns + pause_ns.max(least_ns / 4)).min(by_timer_ns),
            None => by_timer_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_in_the_order_in_which_they_were_sent() {
        let mut stream = Stream::new(Some(1));
        for id in [7, 8, 9] {
            stream.sends(Way::Up, id, true, None);
        }
        let read = |stream: &mut Stream, id| {
            stream.arrives(Way::Up, id);
            std::iter::from_fn(|| stream.reads(Way::Up)).collect::<Vec<_>>()
        };
        assert!(read(&mut stream, 8).is_empty());
        assert!(read(&mut stream, 9).is_empty());
        assert_eq!(read(&mut stream, 7), [7, 8, 9]);
    }

    #[test]
    fn who_sends_on_learns_of_a_loss_before_any_timer_ends() {
        let crossed = |pause_ns| {
            let mut stream = Stream::new(pause_ns);
            stream.sends(Way::Up, 1, true, Some(30_000_000));
            stream.sends(Way::Down, 1, true, Some(10_000_000));
            stream.again_ns(5_000_000, Wheel::new(250, 1)) - 5_000_000
        };
        assert_eq!(crossed(Some(1_000_000)), 50_000_000);
        assert_eq!(crossed(Some(100_000_000)), 140_000_000);
        // 240 ms, then the next tick.
        let by_timer_ns = crossed(None);
        assert!(
            (240_000_000..=244_000_000).contains(&by_timer_ns),
            "{by_timer_ns}"
        );
    }
}
